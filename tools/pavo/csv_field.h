// A field of a CSV line.
#pragma once

#include <string>
#include <string_view>

namespace pavo {

/// Quoted where it must be (RFC 4180). Ends of lines within it become blanks: a record is one line.
inline std::string csv_field(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '\n' || c == '\r' ? ' ' : c;
  if (out.find_first_of(",\"") == std::string::npos) return out;
  std::string quoted = "\"";
  for (const char c : out) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace pavo
