// What an SVG is written with: shapes, text and numbers, as the same bytes in every locale.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/trajectories/polyline.h"

namespace pavo::svg {

/// A coordinate in pixels, at most two decimals, no "-0", no trailing zeros.
std::string px(double value);

/// A tick's label: as many decimals as its step needs.
std::string tick(double value, double step);

/// Text between tags or in an attribute: the five special characters escaped, control characters (which XML forbids)
/// and broken UTF-8 replaced by '?'.
std::string escaped(std::string_view text);

/// How wide a sans-serif font of that size sets the text, roughly, on the safe side.
double text_width_px(std::string_view text, double size_px);

struct Stroke {
  std::string color;
  double width_px = 1;
  double opacity = 1;
};

struct TextStyle {
  double size_px = 14;
  const char* anchor = "start";  ///< "start", "middle" or "end" of the text is at its position
  const char* color = "#222222";
  bool bold = false;
  bool upwards = false;  ///< turned by 90 degrees against the clock
};

/// Collects shapes, in pixels from the top left corner; later ones lie on top. Everything that is text is escaped here.
class Writer {
 public:
  /// One path of several pieces; a piece of one point is a dot.
  void path(const std::vector<Polyline>& pieces, const Stroke& stroke);
  void circle(const Eigen::Vector2d& centre, double radius_px, const Stroke& stroke);
  void outline(const Eigen::Vector2d& low, const Eigen::Vector2d& size, const Stroke& stroke);
  void filled(const Eigen::Vector2d& low, const Eigen::Vector2d& size, std::string_view color, double opacity = 1);
  void text(const Eigen::Vector2d& at, std::string_view what, const TextStyle& style);

  /// The whole file, on white.
  std::string document(const Eigen::Vector2d& size, std::string_view title) const;

 private:
  void open(std::string_view element);
  void attribute(std::string_view name, std::string_view value);  ///< escapes
  void attribute(std::string_view name, double value) { attribute(name, px(value)); }
  void rectangle(const Eigen::Vector2d& low, const Eigen::Vector2d& size);
  void stroke(const Stroke& stroke);

  std::string shapes_;
};

}  // namespace pavo::svg
