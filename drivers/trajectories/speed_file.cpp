#include "drivers/trajectories/speed_file.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "drivers/trajectories/append_file.h"

namespace pavo {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// A message stays one line, whatever the file holds.
std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text) result += c >= ' ' && c <= '~' ? c : '?';
  return result;
}

std::optional<double> number(std::string_view text) {
  text = trimmed(text);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::optional<SpeedSample> parse_speed_line(std::string_view line) {
  constexpr double kLargestSeconds = 9e9;  // in nanoseconds it still fits 64 bits
  const std::size_t comma = line.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::optional<double> t_s = number(line.substr(0, comma)), speed = number(line.substr(comma + 1));
  if (!t_s || !speed || std::abs(*t_s) > kLargestSeconds) return std::nullopt;
  return SpeedSample{std::llround(*t_s * 1e9), *speed};
}

std::vector<SpeedSample> parse_speed(std::string_view text, const std::string& name) {
  std::vector<SpeedSample> samples;
  bool header_allowed = true;
  for (int line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    const std::optional<SpeedSample> s = parse_speed_line(line);
    const std::string where = name + ":" + std::to_string(line_number) + ": ";
    if (!s && !header_allowed)
      throw std::runtime_error(where + "expected two finite numbers \"t,m/s\", found \"" +
                               printable(line.substr(0, 60)) + "\"");
    header_allowed = false;
    if (!s) continue;
    if (!samples.empty() && s->t_ns <= samples.back().t_ns)
      throw std::runtime_error(where + "the times must increase from line to line");
    samples.push_back(*s);
  }
  if (samples.empty()) throw std::runtime_error(name + ": holds no speed; expected lines of \"t,m/s\"");
  return samples;
}

std::vector<SpeedSample> read_speed(const std::string& path) {
  return parse_speed(read_whole_file(path), path);
}

}  // namespace pavo
