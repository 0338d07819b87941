// Real pictures: 32 views of a chessboard whose camera was calibrated and published by others.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "stages/calibration/calibrate_camera.h"
#include "stages/decode/decode.h"
#include "tests/support/data.h"

namespace pavo {
namespace {

TEST(PublishedSet, GivesThePublishedCamera) {
  PAVO_NEEDS_DATA("calibration/chessboard");
  const Board board{.columns = 9, .rows = 6, .square_m = 0.04};
  std::vector<BoardCorners> views;
  const Decode decode;
  Decode::Scratch scratch;
  Image image;
  for (const auto& entry : std::filesystem::directory_iterator(test::data_folder() / "calibration/chessboard")) {
    std::ifstream file(entry.path(), std::ios::binary);
    EncodedImage encoded;
    encoded.bytes.assign(std::istreambuf_iterator<char>(file), {});
    decode(encoded, image, scratch);
    views.push_back(find_board(image.view(), board));
    EXPECT_FALSE(views.back().empty()) << entry.path();
  }
  ASSERT_EQ(views.size(), 32u);
  const CalibrationResult result = calibrate_camera(views, board, 752, 480, Lens::radial_tangential);
  EXPECT_EQ(result.used, 32);
  EXPECT_LT(result.kept_out_rms_px, 0.15);
  EXPECT_LT(result.straightness_px, 0.2);
  EXPECT_NEAR(result.camera.fx, 420.51, 0.005 * 420.51);
  EXPECT_NEAR(result.camera.fy, 420.61, 0.005 * 420.61);
}

}  // namespace
}  // namespace pavo
