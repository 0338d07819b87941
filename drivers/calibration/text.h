// Reading small text files with errors that say where: shared by the readers of calibrations and of sequences.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pavo {

/// A line of a text, without its end ("\n" or "\r\n") and without blanks around it.
struct TextLine {
  int number = 0;  ///< from 1
  std::string_view text;
};

/// The lines that are not blank, nor comments that start with '#'. They point into `text`. A byte order mark is
/// skipped.
std::vector<TextLine> significant_lines(std::string_view text);

/// The fields of a line, parted by blanks and by `separator` (by blanks alone where that is ' ').
std::vector<std::string_view> split_fields(std::string_view line, char separator = ' ');

std::string_view trim(std::string_view text);

/// The number that `text` is, wholly; nothing where it is no number, NaN, infinite or out of range.
std::optional<double> parse_number(std::string_view text);

/// The text with '?' for control characters, so that a message stays one line; quoted() shortens it, too.
std::string printable(std::string_view text);
std::string quoted(std::string_view text);

/// Throws std::runtime_error("FILE:LINE: what"), without the line where it is 0.
[[noreturn]] void fail_at(const std::string& file, int line, const std::string& what);

}  // namespace pavo
