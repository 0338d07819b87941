// The picture of the paths: what is in it, and that nothing breaks it.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "drivers/trajectories/polyline.h"
#include "drivers/trajectories/svg_writer.h"
#include "drivers/trajectories/trajectory_svg.h"
#include "tests/support/temporary.h"

namespace pavo {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

SE3 at(double x, double z) {
  return {Eigen::Matrix3d::Identity(), Eigen::Vector3d(x, 7, z)};
}

TrajectoryPlot plot_of(const std::vector<SE3>& path) {
  return {"A drive", "estimates aligned by Sim(3)", {{"pavo", kPavoColor, {path, {}}, false}}};
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + part.size())) ++n;
  return n;
}

/// The points of the longest path drawn in that colour.
std::size_t points_drawn(const std::string& svg, const std::string& color) {
  std::size_t most = 0, begin = 0;
  while ((begin = svg.find("<path d=\"", begin)) != std::string::npos) {
    const std::string element = svg.substr(begin, svg.find("/>", begin) - begin);
    if (element.find(color) != std::string::npos) most = std::max(most, count(element, "L") + count(element, "M"));
    ++begin;
  }
  return most;
}

void expect_sound(const std::string& svg) {
  EXPECT_THAT(svg, ::testing::StartsWith("<svg "));
  EXPECT_THAT(svg, ::testing::EndsWith("</svg>\n"));
  for (const char* bad : {"nan", "inf", "\"-0\"", "e+", "NaN"}) EXPECT_THAT(svg, Not(HasSubstr(bad)));
  EXPECT_EQ(count(svg, "<text"), count(svg, "</text>"));
}

TEST(Picture, NamesTheCurvesTheAlignmentAndTheAxes) {
  TrajectoryPlot plot = plot_of({at(0, 0), at(10, 50), at(30, 100)});
  plot.curves.push_back({"ground truth", kTruthColor, {{at(0, 0), at(30, 90)}, {}}, true});
  const std::string svg = trajectory_svg(plot);
  expect_sound(svg);
  for (const char* word :
       {"A drive", "pavo", "ground truth", "aligned by Sim(3)", "start", "end", "x (m)", "z (m)", " m</text>"})
    EXPECT_THAT(svg, HasSubstr(word));
  EXPECT_EQ(count(svg, "<circle"), 3u) << "a start per curve, and the legend's";
  EXPECT_LT(svg.find(kTruthColor, svg.find("#e4e4e4")), svg.find(kPavoColor, svg.find("#e4e4e4")))
      << "the truth lies beneath";
}

TEST(Picture, IsSeenFromAboveWithZUpAndEqualAspect) {
  // The path goes 100 m forwards, then 100 m to the right: so up, then right by as many pixels.
  const std::string svg = trajectory_svg(plot_of({at(0, 0), at(0, 100), at(100, 100)}));
  const std::size_t begin = svg.rfind("<path d=\"M", svg.find("<rect x", svg.find("stroke=\"#e4e4e4\"")));
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0, x2 = 0, y2 = 0;
  ASSERT_EQ(std::sscanf(svg.c_str() + begin, "<path d=\"M%lf %lfL%lf %lfL%lf %lf", &x0, &y0, &x1, &y1, &x2, &y2), 6);
  EXPECT_EQ(x1, x0);
  EXPECT_LT(y1, y0);
  EXPECT_EQ(y2, y1);
  EXPECT_NEAR(x2 - x1, y0 - y1, 0.02);
}

TEST(Picture, IsTheSameToTheByte) {
  const TrajectoryPlot plot = plot_of({at(0, 0), at(3.3333, 0.1), at(1e3, -7)});
  EXPECT_EQ(trajectory_svg(plot), trajectory_svg(plot));
  const test::TemporaryFolder folder;
  write_trajectory_svg(folder.file("a.svg"), plot);
  EXPECT_EQ(test::bytes_of(folder.file("a.svg")), trajectory_svg(plot));
  EXPECT_THAT(test::complaint([&] { write_trajectory_svg(folder.file("x/a.svg"), plot); }), HasSubstr("No such file"));
}

TEST(Picture, OfNothingOnePoseOrAStandstillIsSound) {
  expect_sound(trajectory_svg({}));
  expect_sound(trajectory_svg(plot_of({})));
  expect_sound(trajectory_svg(plot_of({at(5, 5)})));
  expect_sound(trajectory_svg(plot_of(std::vector<SE3>(100, at(-1e6, 3)))));
  expect_sound(trajectory_svg(plot_of({at(1e9, -1e9), at(-1e9, 1e9)})));
  expect_sound(trajectory_svg(plot_of({at(0, 0), at(1e-300, 0)})));
}

TEST(Picture, BreaksACurveWhereAPositionIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const std::string svg =
      trajectory_svg(plot_of({at(nan, 0), at(0, 0), at(1, 1), at(0, infinity), at(2, 0), at(3, 0), at(1e300, 0)}));
  expect_sound(svg);
  EXPECT_THAT(svg, ::testing::ContainsRegex("M[0-9. ]+L[0-9. ]+M[0-9. ]+L[0-9. ]+\" fill=\"none\" stroke=\"#1f5fd0\""));
  expect_sound(trajectory_svg(plot_of({at(nan, nan)})));
}

TEST(Picture, EscapesWhatItIsGiven) {
  TrajectoryPlot plot = plot_of({at(0, 0), at(1, 1)});
  plot.title = "<script>&\"'";
  plot.curves[0].label =
      "a\x01"
      "b\xff"
      "c\xC3\xA9";
  const std::string svg = trajectory_svg(plot);
  EXPECT_THAT(svg, HasSubstr("&lt;script&gt;&amp;&quot;&#39;"));
  EXPECT_THAT(svg, HasSubstr("a?b?c\xC3\xA9<"));
  EXPECT_THAT(svg, Not(HasSubstr("<script>")));
}

TEST(Picture, OfALongRunHasABoundedNumberOfPoints) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<SE3> walk{at(0, 0)}, broken;
  for (int i = 0; i < 60'000; ++i) {
    walk.push_back(at(walk.back().t.x() + uniform(random), walk.back().t.z() + uniform(random)));
    broken.push_back(i % 2 ? at(std::nan(""), 0) : walk.back());
  }
  EXPECT_LE(points_drawn(trajectory_svg(plot_of(walk)), kPavoColor), kMostPointsPerCurve);
  EXPECT_LE(points_drawn(trajectory_svg(plot_of(broken)), kPavoColor), kMostPointsPerCurve);
  std::vector<SE3> straight;
  for (int i = 0; i < 30'000; ++i) straight.push_back(at(0, i));
  EXPECT_EQ(points_drawn(trajectory_svg(plot_of(straight)), kPavoColor), 2u);
}

TEST(Thinning, StaysWithinTheToleranceOfEveryPoint) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Polyline line{{0, 0}};
  for (int i = 0; i < 500; ++i) line.push_back(line.back() + Eigen::Vector2d(1 + uniform(random), uniform(random)));
  const Polyline kept = thinned(line, 0.5, 1000);
  EXPECT_LT(kept.size(), line.size());
  EXPECT_EQ(kept.front(), line.front());
  EXPECT_EQ(kept.back(), line.back());
  for (const Eigen::Vector2d& p : line) {
    double nearest = 1e9;
    for (std::size_t i = 1; i < kept.size(); ++i) {
      const Eigen::Vector2d a = kept[i - 1], ab = kept[i] - a;
      nearest = std::min(nearest, (p - a - std::clamp(ab.dot(p - a) / ab.squaredNorm(), 0.0, 1.0) * ab).norm());
    }
    EXPECT_LE(nearest, 0.5 + 1e-12);
  }
  EXPECT_LE(thinned(line, 0, 10).size(), 10u);
}

TEST(RoundSteps, AreOneTwoOrFive) {
  for (const auto& [least, step] : std::vector<std::pair<double, double>>{
           {1, 1}, {1.1, 2}, {2.1, 5}, {5.1, 10}, {0.03, 0.05}, {70, 100}, {200, 200}})
    EXPECT_NEAR(round_step(least), step, 1e-12);
}

TEST(SvgNumbers, AreShortAndHaveNoMinusZero) {
  EXPECT_EQ(svg::px(1), "1");
  EXPECT_EQ(svg::px(1.005), "1");
  EXPECT_EQ(svg::px(100), "100");
  EXPECT_EQ(svg::px(-0.001), "0");
  EXPECT_EQ(svg::px(-12.5), "-12.5");
  EXPECT_EQ(svg::tick(0.30000000000000004, 0.1), "0.3");
  EXPECT_EQ(svg::tick(-20, 20), "\u221220");
  EXPECT_EQ(svg::tick(-0.0, 5), "0");
  EXPECT_EQ(svg::tick(0.25, 0.05), "0.25");
}

}  // namespace
}  // namespace pavo
