// Times and lists of frames in the files of recorded sequences, exact to the nanosecond.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pavo {

/// Decimal seconds ("1305031102.175304", "1.042283e-01") in nanoseconds, rounded half away from zero where there are
/// more digits than that; nothing where it is no number, or beyond int64. No floating point is involved.
std::optional<std::int64_t> parse_seconds(std::string_view text);

/// "2011-09-26 13:02:25.594360375" (KITTI raw; taken for UTC) in nanoseconds since 1970.
std::optional<std::int64_t> parse_date_time(std::string_view text);

/// A line of a list of frames: when it was taken, and the file that holds it.
struct IndexEntry {
  std::int64_t t_ns = 0;
  std::string file;
};

/// EuRoC's data.csv: "nanoseconds,file" a line. TUM's rgb.txt: "seconds file" a line. Both: '#' begins a comment, times
/// increase. They throw std::runtime_error("NAME:LINE: ...").
std::vector<IndexEntry> parse_euroc_index(std::string_view text, const std::string& name);
std::vector<IndexEntry> parse_tum_index(std::string_view text, const std::string& name);

/// KITTI raw's timestamps.txt: a date and time a line, increasing.
std::vector<std::int64_t> parse_timestamps(std::string_view text, const std::string& name);

}  // namespace pavo
