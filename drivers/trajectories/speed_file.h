// Wheel or GPS speed as a file: "t,m/s" a line, seconds and metres per second.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pavo {

struct SpeedSample {
  std::int64_t t_ns = 0;
  double m_per_s = 0;
};

/// CSV with two columns, an optional header line, '#' comments and blank lines. Times increase strictly, speeds are
/// finite. Throws std::runtime_error of one line, "FILE:LINE: ...". Any thread; blocks for the file system.
std::vector<SpeedSample> read_speed(const std::string& path);
/// One line of it, without its end; nothing where it is none (a comment, a header).
std::optional<SpeedSample> parse_speed_line(std::string_view line);
/// The same from memory; `name` stands for the file in messages.
std::vector<SpeedSample> parse_speed(std::string_view text, const std::string& name);

}  // namespace pavo
