// Whatever cannot be a calibration is refused, in one line that names the file, the line and the key.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/calibration/calibration.h"
#include "tests/calibration/error_of.h"

namespace pavo {
namespace {

using test::error_of;
using testing::HasSubstr;

struct Bad {
  const char* name;
  std::string text;
  const char* complaint;
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

std::string name_of(const testing::TestParamInfo<Bad>& bad) {
  return bad.param.name;
}

class RefusesCalibration : public testing::TestWithParam<Bad> {};

TEST_P(RefusesCalibration, InOneLine) {
  const std::string message = error_of([] { parse_calibration(GetParam().text, "FILE"); });
  EXPECT_THAT(message, HasSubstr(GetParam().complaint));
  EXPECT_THAT(message, testing::StartsWith("FILE"));
}

const std::string kTail = " 0 0 1 0\n";

INSTANTIATE_TEST_SUITE_P(
    Kitti, RefusesCalibration,
    testing::Values(Bad{"empty", "", "is empty"}, Bad{"blank", " \n\n# nothing\n", "is empty"},
                    Bad{"nan", "# a comment\nP0: nan 0 600 0 0 700 180 0 0 0 1 0\n", "FILE:2: P0 has 'nan'"},
                    Bad{"infinite", "P0: 700 0 inf 0 0 700 180 0 0 0 1 0\n", "FILE:1: P0 has 'inf'"},
                    Bad{"word", "P0: 700 0 6OO 0 0 700 180 0 0 0 1 0\n", "FILE:1: P0 has '6OO'"},
                    Bad{"eleven", "P0: 700 0 600 0 0 700 180 0 0 0 1\n", "FILE:1: P0 has 11 values"},
                    Bad{"thirteen", "P0: 700 0 600 0 0 700 180 0 0 0 1 0 0\n", "FILE:1: P0 has 13 values"},
                    Bad{"zero_focal_length", "P0: 0 0 600 0 0 700 180 0 0 0 1 0\n",
                        "FILE:1: P0 has the focal length 0"},
                    Bad{"negative_focal_length", "P0: 700 0 600 0 0 -700 180 0 0 0 1 0\n", "focal length -700"},
                    Bad{"normalised_focal_length", "P0: 0.57 0 0.5 0 0 0.76 0.5 0 0 0 1 0\n", "focal length 0.57"},
                    Bad{"huge_focal_length", "P0: 1e300 0 600 0 0 700 180 0 0 0 1 0\n", "focal length 1e+300"},
                    Bad{"skew", "P0: 700 3 600 0 0 700 180 0 0 0 1 0\n", "skew is not supported"},
                    Bad{"no_projection", "P0: 700 0 600 0 0 700 180 0 0 0 2 0\n", "P0 is no camera matrix"},
                    Bad{"twice", "P0: 700 0 6 0 0 700 1 0 0 0 1 0\nP0: 700 0 6 0 0 700 1 0 0 0 1 0\n",
                        "FILE:2: 'P0' comes a second time"},
                    Bad{"no_key", "P0: 700 0 6 0 0 700 1 0 0 0 1 0\n700 0 6\n", "FILE:2: expected 'key: numbers'"},
                    Bad{"raw_without_size", "P_rect_00: 700 0 600 0 0 700 180 0 0 0 1 0\n", "has no S_rect_00"},
                    Bad{"raw_size", "P_rect_00: 700 0 600 0 0 700 180 0 0 0 1 0\nS_rect_00: 1242.5 375\n",
                        "image size 1242.5x375"}),
    name_of);

std::string euroc(const std::string& intrinsics, const std::string& rest) {
  return "sensor_type: camera\nintrinsics: " + intrinsics + "\n" + rest;
}

const std::string kRest =
    "resolution: [752, 480]\ncamera_model: pinhole\ndistortion_model: radial-tangential\ndistortion_coefficients: "
    "[0.1, 0, 0, 0]\n";
const std::string kGood = "[450, 451, 370, 240]";

INSTANTIATE_TEST_SUITE_P(
    Euroc, RefusesCalibration,
    testing::Values(
        Bad{"not_a_number", euroc("[450, .nan, 370, 240]", kRest), "FILE:2: intrinsics has '.nan'"},
        Bad{"three", euroc("[450, 370, 240]", kRest), "FILE:2: intrinsics has 3 numbers: expected 4"},
        Bad{"no_list", euroc("450", kRest), "FILE:2: intrinsics is no list of numbers"},
        Bad{"a_map_in_it", euroc("[450, {a: 1}, 370, 240]", kRest), "intrinsics has something else"},
        Bad{"principal_point", euroc("[450, 451, 3700, 240]", kRest),
            "principal point at (3700, 240), far outside the image of 752x480"},
        Bad{"no_resolution", euroc(kGood, "distortion_model: none\n"), "has no resolution"},
        Bad{"no_model", euroc(kGood, "resolution: [752, 480]\n"), "has no distortion_model"},
        Bad{"no_coefficients", euroc(kGood, "resolution: [752, 480]\ndistortion_model: radial-tangential\n"),
            "has no distortion_coefficients"},
        Bad{"no_intrinsics", "camera_model: pinhole\n", "has no intrinsics"},
        Bad{"size_zero", euroc(kGood, "resolution: [0, 480]\ndistortion_model: none\n"),
            "FILE:3: resolution has the image size 0x480"},
        Bad{"omni", "camera_model: omni\nintrinsics: [1, 2, 3, 4]\n",
            "FILE:1: camera_model is 'omni': expected pinhole"},
        Bad{"imu", "sensor_type: imu\nintrinsics: [1, 2, 3, 4]\n", "sensor_type is 'imu': expected camera"},
        Bad{"unknown_model", euroc(kGood, "resolution: [752, 480]\ndistortion_model: fov\n"),
            "FILE:4: distortion_model is 'fov'"},
        Bad{"three_coefficients",
            euroc(kGood, "resolution: [752, 480]\ndistortion_model: radtan\ndistortion_coefficients: [1, 2, 3]\n"),
            "FILE:5: distortion_coefficients has 3 values"},
        Bad{"five_for_fisheye",
            euroc(kGood,
                  "resolution: [752, 480]\ndistortion_model: equidistant\ndistortion_coefficients: [1, 2, 3, 4, 5]\n"),
            "has 5 values: expected the 4 of an equidistant lens"},
        Bad{"place_in_the_body", euroc(kGood, kRest + "T_BS: [1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"),
            "FILE:7: T_BS is not a rotation"},
        Bad{"not_rigid", euroc(kGood, kRest + "T_BS: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1]\n"),
            "T_BS does not end with the row 0 0 0 1"},
        Bad{"twice", euroc(kGood, kRest + "intrinsics: [1, 2, 3, 4]\n"), "FILE:7: 'intrinsics' comes a second time"}),
    name_of);

std::string ros(const std::string& matrix, const std::string& distortion,
                const std::string& size = "image_width: 640\nimage_height: 480\n") {
  return size + "camera_matrix: " + matrix + "\ndistortion_coefficients: " + distortion + "\n";
}

const std::string kMatrix = "{rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}";
const std::string kZeros = "[0, 0, 0, 0, 0]";

INSTANTIATE_TEST_SUITE_P(
    Matrices, RefusesCalibration,
    testing::Values(
        Bad{"uncalibrated", ros("[0, 0, 0, 0, 0, 0, 0, 0, 0]", kZeros), "FILE:3: camera_matrix has the focal length 0"},
        Bad{"eight", ros("{rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0]}", kZeros),
            "has 8 numbers, which rows x cols does not say"},
        Bad{"twelve", ros("[500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]", kZeros), "has 12 numbers: expected 9"},
        Bad{"infinite", ros("[500, 0, .inf, 0, 500, 240, 0, 0, 1]", kZeros), "camera_matrix has '.inf'"},
        Bad{"thin_prism", ros(kMatrix, "[0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0, 0, 0]"),
            "FILE:4: distortion_coefficients has a nonzero coefficient at place 9"},
        Bad{"six_coefficients", ros(kMatrix, "[0, 0, 0, 0, 0, 0]"), "has 6 values"},
        Bad{"no_size", ros(kMatrix, kZeros, ""), "has no image_width"},
        Bad{"no_height", ros(kMatrix, kZeros, "image_width: 640\n"), "has no image_height"},
        Bad{"negative_size", ros(kMatrix, kZeros, "image_width: -640\nimage_height: 480\n"), "image size -640x480"},
        Bad{"size_is_a_word", ros(kMatrix, kZeros, "image_width: wide\nimage_height: 480\n"),
            "FILE:1: image_width has 'wide'"},
        Bad{"no_distortion", "image_width: 640\nimage_height: 480\nK: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n",
            "has no distortion_coefficients"},
        Bad{"binned", ros(kMatrix, kZeros, "image_width: 640\nimage_height: 480\nbinning_x: 2\n"),
            "binning_x is not supported"},
        Bad{"surplus_zero_is_fine_but_skew_is_not",
            ros("[500, 1, 320, 0, 500, 240, 0, 0, 1]", "[0,0,0,0,0,0,0,0,0,0,0,0,0,0]"), "skew"}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    NoCalibration, RefusesCalibration,
    testing::Values(Bad{"prose", "This is no calibration.\n", "is no camera calibration"},
                    Bad{"other_yaml", "%YAML:1.0\n---\nnothing: here\n", "has no camera"},
                    Bad{"broken_yaml", "a: 1\nintrinsics: [1, 2\nb: [\n", "is no calibration and no YAML"},
                    Bad{"list", "- 1\n- 2\n", "is no camera calibration"},
                    Bad{"xml", "<?xml version=\"1.0\"?>\n<opencv_storage>\n</opencv_storage>\n", "FILE"},
                    Bad{"binary", std::string("\x89PNG\r\n\x1a\n\0\0\0", 11), "FILE"},
                    Bad{"deep", std::string(100000, '['), "is no calibration and no YAML"}),
    name_of);

TEST(CalibrationFile, ThatIsNotThereIsNamed) {
  EXPECT_THAT(error_of([] { read_calibration("/no/such/calib.txt"); }), HasSubstr("/no/such/calib.txt"));
}

TEST(CalibrationFile, ThatIsADirectoryIsNamed) {
  EXPECT_THAT(error_of([] { read_calibration("/tmp"); }), HasSubstr("/tmp"));
}

}  // namespace
}  // namespace pavo
