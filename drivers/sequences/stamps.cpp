#include "drivers/sequences/stamps.h"

#include <charconv>
#include <chrono>

#include "drivers/calibration/text.h"
#include "drivers/sequences/directory.h"

namespace pavo {
namespace {

constexpr std::size_t kLongestNumber = 64;
constexpr int kLargestExponent = 64;

template <typename Integer>
std::optional<Integer> parse_integer(std::string_view text) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// digits * 10^exponent as an integer, rounded half up; nothing where it does not fit.
std::optional<std::int64_t> scaled(std::string digits, int exponent) {
  digits.erase(0, digits.find_first_not_of('0'));
  if (digits.empty()) return 0;
  bool round_up = false;
  if (exponent >= 0) {
    digits.append(static_cast<std::size_t>(exponent), '0');
  } else {
    const auto cut = static_cast<std::size_t>(-exponent);
    if (cut > digits.size()) return 0;
    round_up = digits[digits.size() - cut] >= '5';
    digits.resize(digits.size() - cut);
  }
  const auto value = digits.empty() ? 0 : parse_integer<std::int64_t>(digits);
  if (!value || *value == INT64_MAX) return std::nullopt;
  return *value + (round_up ? 1 : 0);
}

/// Every entry's time must come after the one before it.
void check_order(std::int64_t before_ns, std::int64_t t_ns, const std::string& name, int line) {
  if (t_ns > before_ns) return;
  fail_at(name, line,
          "the time does not come after the one before it: expected increasing times; repair or cut the file");
}

using TimeParser = std::optional<std::int64_t> (*)(std::string_view);

std::vector<IndexEntry> parse_index(std::string_view text, const std::string& name, char separator,
                                    TimeParser parse_time, const std::string& expected) {
  std::vector<IndexEntry> entries;
  for (const TextLine& line : significant_lines(text)) {
    const auto fields = split_fields(line.text, separator);
    const auto t_ns = parse_time(fields[0]);
    if (fields.size() != 2 || !t_ns || fields[1].empty() || fields[1].find('\0') != std::string_view::npos) {
      fail_at(name, line.number, "expected " + expected + ", found " + quoted(line.text));
    }
    if (!entries.empty()) check_order(entries.back().t_ns, *t_ns, name, line.number);
    entries.push_back({*t_ns, std::string(fields[1])});
  }
  if (entries.empty()) fail_at(name, 0, "lists no frame: expected lines of " + expected);
  return entries;
}

}  // namespace

std::optional<std::int64_t> parse_seconds(std::string_view text) {
  if (text.size() > kLongestNumber) return std::nullopt;
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  std::string digits;
  int exponent = 9;
  bool point = false;
  std::size_t i = 0;
  for (; i < text.size() && (is_digit(text[i]) || (text[i] == '.' && !point)); ++i) {
    if (text[i] == '.') {
      point = true;
    } else {
      digits += text[i];
      exponent -= point ? 1 : 0;
    }
  }
  if (digits.empty()) return std::nullopt;
  if (i < text.size()) {
    if (text[i] != 'e' && text[i] != 'E') return std::nullopt;
    std::string_view power = text.substr(i + 1);
    if (power.size() > 1 && power[0] == '+' && is_digit(power[1])) power.remove_prefix(1);
    const auto given = parse_integer<int>(power);
    if (!given || *given > kLargestExponent || *given < -kLargestExponent) return std::nullopt;
    exponent += *given;
  }
  const auto value = scaled(std::move(digits), exponent);
  if (!value) return std::nullopt;
  return negative ? -*value : *value;
}

std::optional<std::int64_t> parse_date_time(std::string_view text) {
  using namespace std::chrono;
  // "YYYY-MM-DD hh:mm:ss[.fraction]"
  if (text.size() < 19 || text[4] != '-' || text[7] != '-' || text[10] != ' ' || text[13] != ':' || text[16] != ':') {
    return std::nullopt;
  }
  const auto number = [&](std::size_t begin, std::size_t count) {
    return parse_integer<unsigned>(text.substr(begin, count));
  };
  const auto year_ = number(0, 4), month_ = number(5, 2), day_ = number(8, 2), hour_ = number(11, 2),
             minute_ = number(14, 2);
  if (!year_ || !month_ || !day_ || !hour_ || !minute_ || *hour_ > 23 || *minute_ > 59) return std::nullopt;
  const year_month_day date{year{static_cast<int>(*year_)}, month{*month_}, day{*day_}};
  // int64 nanoseconds since 1970 end in 2262.
  if (!date.ok() || *year_ < 1970 || *year_ > 2261 || !is_digit(text[17])) return std::nullopt;
  const auto second_ns = parse_seconds(text.substr(17));
  constexpr std::int64_t kMinute_ns = 60'000'000'000;
  if (!second_ns || *second_ns < 0 || *second_ns > kMinute_ns) return std::nullopt;
  const std::int64_t minutes = (sys_days(date).time_since_epoch().count() * 24 + *hour_) * 60LL + *minute_;
  return minutes * kMinute_ns + *second_ns;
}

std::vector<IndexEntry> parse_euroc_index(std::string_view text, const std::string& name) {
  return parse_index(text, name, ',', parse_integer<std::int64_t>, "'nanoseconds,file'");
}

std::vector<IndexEntry> parse_tum_index(std::string_view text, const std::string& name) {
  return parse_index(text, name, ' ', parse_seconds, "'seconds file'");
}

std::vector<std::int64_t> parse_timestamps(std::string_view text, const std::string& name) {
  std::vector<std::int64_t> times_ns;
  for (const TextLine& line : significant_lines(text)) {
    const auto t_ns = parse_date_time(line.text);
    if (!t_ns) fail_at(name, line.number, "expected 'YYYY-MM-DD hh:mm:ss.fraction', found " + quoted(line.text));
    if (!times_ns.empty()) check_order(times_ns.back(), *t_ns, name, line.number);
    times_ns.push_back(*t_ns);
  }
  if (times_ns.empty()) fail_at(name, 0, "has no time: expected lines of 'YYYY-MM-DD hh:mm:ss.fraction'");
  return times_ns;
}

}  // namespace pavo
