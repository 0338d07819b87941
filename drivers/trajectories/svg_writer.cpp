#include "drivers/trajectories/svg_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace pavo::svg {
namespace {

std::string fixed(double value, int decimals) {
  std::array<char, 352> digits{};
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, decimals).ptr;
  std::string text(digits.data(), end);
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

/// The length of the UTF-8 sequence that starts here; 0: it is broken.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t length = byte(0) < 0x80                      ? 1
                             : byte(0) >= 0xC2 && byte(0) < 0xE0 ? 2
                             : (byte(0) & 0xF0) == 0xE0          ? 3
                             : byte(0) >= 0xF0 && byte(0) < 0xF5 ? 4
                                                                 : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  if (length == 3) {  // overlong forms, surrogates, and the two non-characters that XML forbids
    const unsigned point = (byte(0) & 0xFu) << 12 | (byte(1) & 0x3Fu) << 6 | (byte(2) & 0x3Fu);
    if (point < 0x800 || (point >= 0xD800 && point < 0xE000) || point >= 0xFFFE) return 0;
  }
  if (length == 4 && ((byte(0) == 0xF0 && byte(1) < 0x90) || (byte(0) == 0xF4 && byte(1) >= 0x90))) return 0;
  return length;
}

}  // namespace

std::string px(double value) {
  std::string text = fixed(value, 2);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string tick(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  std::string text = fixed(value, decimals);
  if (text[0] == '-') text.replace(0, 1, "\u2212");  // a minus sign, not a hyphen
  return text;
}

std::string escaped(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char c = text[0];
    if (length == 0 || (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f)
      result += '?';
    else if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if (c == '\'')
      result += "&#39;";
    else
      result += text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result;
}

double text_width_px(std::string_view text, double size_px) {
  const auto starts =
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  return 0.58 * size_px * static_cast<double>(starts);
}

void Writer::open(std::string_view element) {
  shapes_ += '<';
  shapes_ += element;
}

void Writer::attribute(std::string_view name, std::string_view value) {
  shapes_ += ' ';
  shapes_ += name;
  shapes_ += "=\"";
  shapes_ += escaped(value);
  shapes_ += '"';
}

void Writer::stroke(const Stroke& stroke) {
  attribute("fill", "none");
  attribute("stroke", stroke.color);
  attribute("stroke-width", stroke.width_px);
  if (stroke.opacity < 1) attribute("stroke-opacity", stroke.opacity);
}

void Writer::rectangle(const Eigen::Vector2d& low, const Eigen::Vector2d& size) {
  open("rect");
  attribute("x", low.x());
  attribute("y", low.y());
  attribute("width", size.x());
  attribute("height", size.y());
}

void Writer::path(const std::vector<Polyline>& pieces, const Stroke& how) {
  std::string data;
  for (const Polyline& piece : pieces) {
    for (std::size_t i = 0; i < piece.size(); ++i) {
      data += i == 0 ? 'M' : 'L';
      data += px(piece[i].x());
      data += ' ';
      data += px(piece[i].y());
    }
    if (piece.size() == 1) data += "h0";  // its round cap is the dot
  }
  open("path");
  attribute("d", data);
  stroke(how);
  shapes_ += " stroke-linejoin=\"round\" stroke-linecap=\"round\"/>\n";
}

void Writer::circle(const Eigen::Vector2d& centre, double radius_px, const Stroke& how) {
  open("circle");
  attribute("cx", centre.x());
  attribute("cy", centre.y());
  attribute("r", radius_px);
  stroke(how);
  shapes_ += "/>\n";
}

void Writer::outline(const Eigen::Vector2d& low, const Eigen::Vector2d& size, const Stroke& how) {
  rectangle(low, size);
  stroke(how);
  shapes_ += "/>\n";
}

void Writer::filled(const Eigen::Vector2d& low, const Eigen::Vector2d& size, std::string_view color, double opacity) {
  rectangle(low, size);
  attribute("fill", color);
  if (opacity < 1) attribute("fill-opacity", opacity);
  shapes_ += "/>\n";
}

void Writer::text(const Eigen::Vector2d& at, std::string_view what, const TextStyle& style) {
  open("text");
  attribute("x", at.x());
  attribute("y", at.y());
  attribute("font-size", style.size_px);
  attribute("text-anchor", style.anchor);
  attribute("fill", style.color);
  if (style.bold) attribute("font-weight", "bold");
  if (style.upwards) attribute("transform", "rotate(-90 " + px(at.x()) + " " + px(at.y()) + ")");
  shapes_ += '>';
  shapes_ += escaped(what);
  shapes_ += "</text>\n";
}

std::string Writer::document(const Eigen::Vector2d& size, std::string_view title) const {
  const std::string width = px(size.x()), height = px(size.y());
  std::string text = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height +
                     "\" viewBox=\"0 0 " + width + " " + height + "\" role=\"img\">\n<title>" + escaped(title) +
                     "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  text += "<g font-family=\"Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif\">\n";
  return text + shapes_ + "</g>\n</svg>\n";
}

}  // namespace pavo::svg
