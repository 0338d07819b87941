// Pictures of boards through a lens that is known: what is found is within three of its own standard deviations.
#include <gtest/gtest.h>

#include "stages/calibration/bundle.h"
#include "stages/calibration/calibrate_camera.h"
#include "tests/board_calibration/boards.h"

namespace pavo::test {
namespace {

std::vector<BoardCorners> found_in_pictures(const Camera& camera, int count, unsigned seed) {
  std::mt19937 random(seed);
  const BoardPainter painter(camera);
  Image image;
  std::vector<BoardCorners> views;
  for (const SE3& pose : poses(camera, count, seed)) {
    painter.paint(pose, 2, random, image);
    BoardCorners corners = find_board(image.view(), kBoard);
    if (!corners.empty()) views.push_back(std::move(corners));
  }
  EXPECT_GE(static_cast<int>(views.size()), count - 1);
  return views;
}

class RenderedBoards : public ::testing::TestWithParam<Camera> {};

TEST_P(RenderedBoards, GiveBackTheCameraWithinThreeStandardDeviations) {
  Camera truth = GetParam();
  const CalibrationResult result =
      calibrate_camera(found_in_pictures(truth, 12, 1), kBoard, truth.width, truth.height, truth.lens);
  Camera found = result.camera, sigma = result.sigma;
  for (int i = 0; i < parameter_count(truth.lens); ++i)
    EXPECT_LT(std::abs(parameter(found, i) - parameter(truth, i)), 3 * parameter(sigma, i))
        << "parameter " << i << ": " << parameter(found, i) << " for " << parameter(truth, i);
  EXPECT_LT(sigma.fx, 0.005 * truth.fx);
  EXPECT_LT(result.rms_px, 0.1);
  EXPECT_LT(result.kept_out_rms_px, 0.12);
  EXPECT_LT(result.straightness_px, 0.1);
}

TEST_P(RenderedBoards, AreFoundWhereTheyAre) {
  const Camera& camera = GetParam();
  std::mt19937 random(7);
  const BoardPainter painter(camera);
  Image image;
  for (const SE3& pose : poses(camera, 3, 5)) {
    painter.paint(pose, 2, random, image);
    const BoardCorners truth = corners_seen(camera, pose, 0, random);
    for (const BoardSearch search : {BoardSearch::thorough, BoardSearch::quick}) {
      const BoardCorners found = find_board(image.view(), kBoard, search);
      if (found.empty() && search == BoardSearch::quick) continue;  // it may give up
      ASSERT_EQ(found.size(), truth.size());
      const bool turned = (found.front() - truth.front()).norm() > (found.front() - truth.back()).norm();
      for (std::size_t i = 0; i < truth.size(); ++i)
        EXPECT_LT((found[i] - truth[turned ? truth.size() - 1 - i : i]).norm(), 0.35) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, RenderedBoards, ::testing::Values(pinhole(), fisheye()),
                         [](const auto& i) { return i.param.lens == Lens::equidistant ? "Fisheye" : "Pinhole"; });

TEST(FindBoard, FindsNoneWhereThereIsNone) {
  Image blank(160, 120), other(480, 360);
  for (int y = 0; y < 120; ++y) std::fill_n(blank.row(y), 160, std::uint8_t{90});
  EXPECT_TRUE(find_board(blank.view(), kBoard).empty());
  EXPECT_TRUE(find_board(blank.view(), kBoard, BoardSearch::quick).empty());
  std::mt19937 random(1);
  BoardPainter(pinhole()).paint(poses(pinhole(), 1, 1).front(), 2, random, other);
  EXPECT_TRUE(find_board(other.view(), {.columns = 11, .rows = 4}).empty());
}

TEST(FindBoard, RefusesWhatCannotBeLookedFor) {
  const Image image(64, 64);
  EXPECT_THROW(find_board(image.view(), {.columns = 2, .rows = 6}), std::invalid_argument);
  EXPECT_THROW(find_board(ImageView{}, kBoard), std::invalid_argument);
}

}  // namespace
}  // namespace pavo::test
