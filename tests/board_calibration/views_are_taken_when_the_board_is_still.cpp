// From a camera: which frames become views, and what is still to be shown.
#include <gmock/gmock.h>

#include "stages/calibration/collect_views.h"
#include "stages/calibration/coverage.h"
#include "tests/board_calibration/boards.h"

namespace pavo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kFrame_ns = 33'000'000;

BoardCorners board_at(double x, double y, double side = 100) {
  BoardCorners corners;
  for (int i = 0; i < kBoard.corners(); ++i)
    corners.emplace_back(x + side * (i % kBoard.columns) / (kBoard.columns - 1),
                         y + side * (i / kBoard.columns) / (kBoard.rows - 1));
  return corners;
}

class Collecting : public ::testing::Test {
 protected:
  Seen show(const BoardCorners& corners) { return collect((++frame) * kFrame_ns, corners); }
  CollectViews collect{480, 360};
  std::int64_t frame = 0;
};

TEST_F(Collecting, TakesAViewOnceTheBoardHasBeenStill) {
  EXPECT_EQ(show({}), Seen::nothing);
  int shown = 1;
  for (; show(board_at(50, 60)) == Seen::moving; ++shown) {
  }
  EXPECT_EQ(shown, 14);  // the first, and 0.4 s more
  EXPECT_EQ(collect.views().size(), 1u);
  EXPECT_EQ(show(board_at(50, 60)), Seen::known_place);
}

TEST_F(Collecting, TakesNothingFromAMovingBoard) {
  for (int i = 0; i < 100; ++i) EXPECT_EQ(show(board_at(50 + 2 * i, 60)), Seen::moving);
  EXPECT_TRUE(collect.views().empty());
}

TEST_F(Collecting, StartsAnewWhereTheBoardWasOutOfSight) {
  for (int i = 0; i < 10; ++i) show(board_at(50, 60));
  show({});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(show(board_at(50, 60)), Seen::moving);
}

TEST_F(Collecting, WantsANewPlaceSizeOrTilt) {
  const auto hold = [&](const BoardCorners& corners) {
    for (int i = 0; i < 30; ++i) show(corners);
    return collect.views().size();
  };
  EXPECT_EQ(hold(board_at(50, 60)), 1u);
  EXPECT_EQ(hold(board_at(52, 60)), 1u);
  EXPECT_EQ(hold(board_at(150, 60)), 2u);
  EXPECT_EQ(hold(board_at(50, 60, 200)), 3u);
  BoardCorners turned = board_at(50, 60);
  std::reverse(turned.begin(), turned.end());
  EXPECT_EQ(hold(turned), 3u);  // seen from its other end it is where it was
}

TEST(Coverage, NamesWhatIsMissing) {
  EXPECT_THAT(missing_views(coverage_of({}, kBoard, 480, 360)), ::testing::SizeIs(13));
  const std::vector<BoardCorners> one{board_at(10, 10, 460)};
  const auto missing = missing_views(coverage_of(one, kBoard, 480, 480));
  EXPECT_THAT(missing, ::testing::Contains("the board tilted, its left side nearer"));
  EXPECT_THAT(missing, ::testing::Not(::testing::Contains("the top left corner of the image"))) << missing.front();
}

TEST(Coverage, SeesTiltsAsTheImageHasThem) {
  Camera camera = pinhole();
  camera.distortion = {};
  std::mt19937 random(0);
  const auto tilted = [&](double about_x, double about_y, double about_z) {
    SE3 T;
    T.R = (Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(about_z, Eigen::Vector3d::UnitZ()))
              .toRotationMatrix();
    T.t = Eigen::Vector3d(0, 0, 0.5) - T.R * Eigen::Vector3d(0.105, 0.075, 0);
    const std::vector<BoardCorners> view{corners_seen(camera, T, 0, random)};
    const Coverage c = coverage_of(view, kBoard, camera.width, camera.height);
    return std::array{c.left_nearer, c.right_nearer, c.top_nearer, c.bottom_nearer};
  };
  // Turned about y (down) by a positive angle, the board's right side comes nearer: x' = .., z' = -x sin.
  EXPECT_THAT(tilted(0, 0.5, 0), ElementsAre(0, 1, 0, 0));
  EXPECT_THAT(tilted(0, -0.5, 0), ElementsAre(1, 0, 0, 0));
  EXPECT_THAT(tilted(0.5, 0, 0), ElementsAre(0, 0, 1, 0));
  EXPECT_THAT(tilted(-0.5, 0, 0), ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(tilted(0, 0.5, M_PI), ElementsAre(0, 1, 0, 0)) << "the board held upside down";
  EXPECT_THAT(tilted(0, 0, 0), ElementsAre(0, 0, 0, 0));
}

}  // namespace
}  // namespace pavo::test
