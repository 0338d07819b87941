#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "drivers/synthetic/write_kitti.h"
#include "tests/synthetic/support.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;
using test::small_street;
using testing::HasSubstr;

class WrittenFolder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("pavo-synthetic-" + std::to_string(getpid()) + "-" + test->name());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string text(const char* name) const {
    std::ifstream file(folder_ / name);
    std::stringstream all;
    all << file.rdbuf();
    return all.str();
  }

  fs::path folder_;
};

TEST_F(WrittenFolder, HoldsTheSameFramesPosesTimesAndCamera) {
  SyntheticOptions options = small_street(5);
  options.noise_sigma = 1;
  EXPECT_EQ(write_kitti_folder(options, folder_.string()), 5);
  const auto frames = test::render(options);
  const SyntheticStreet street(options);

  const auto read = open_sequence(folder_.string(), {});
  EXPECT_EQ(read->info().layout, "KITTI odometry");
  EXPECT_EQ(read->info().frame_count, 5);
  ASSERT_TRUE(read->info().camera && read->info().groundtruth);
  EXPECT_NEAR(read->info().camera->fx, street.info().camera->fx, 1e-8);
  EXPECT_NEAR(read->info().camera->cy, street.info().camera->cy, 1e-8);
  EncodedImage image;
  FrameStamp stamp;
  for (std::size_t k = 0; k < 5; ++k) {
    ASSERT_TRUE(read->read(image, stamp));
    EXPECT_NEAR(static_cast<double>(stamp.t_capture_ns), static_cast<double>(k) * 1e8, 10);
    const cv::Mat decoded = cv::imdecode(image.bytes, cv::IMREAD_UNCHANGED);
    ASSERT_EQ(decoded.type(), CV_8U);
    ASSERT_EQ(decoded.size(), cv::Size(320, 96));
    EXPECT_TRUE(std::equal(decoded.begin<std::uint8_t>(), decoded.end<std::uint8_t>(), frames[k].pixels.begin()));
    const SE3 error = street.info().groundtruth->T_w_c[k].inverse() * read->info().groundtruth->T_w_c[k];
    EXPECT_LT(error.t.norm(), 1e-7);
    EXPECT_TRUE(error.R.isIdentity(1e-7));
  }
}

TEST_F(WrittenFolder, NamesEveryFrameInPeopleCsv) {
  SyntheticOptions options = small_street(4);
  options.people = false;
  write_kitti_folder(options, folder_.string());
  EXPECT_EQ(text("people.csv"),
            "image,x,y,width,height,ignore\n000000.png,,,,,\n000001.png,,,,,\n000002.png,,,,,\n000003.png,,,,,\n");
  fs::remove_all(folder_);

  options.companions = 3;
  write_kitti_folder(options, folder_.string());
  const SyntheticStreet street(options);
  std::istringstream lines(text("people.csv"));
  std::string line;
  std::getline(lines, line);
  for (int k = 0; k < 4; ++k) {
    for (const SyntheticPerson& p : street.people(k)) {
      if (p.visible_fraction < 0.05F) continue;
      ASSERT_TRUE(std::getline(lines, line));
      float x, y, w, h;
      int frame, ignore;
      ASSERT_EQ(std::sscanf(line.c_str(), "%d.png,%f,%f,%f,%f,%d", &frame, &x, &y, &w, &h, &ignore), 6) << line;
      EXPECT_EQ(frame, k);
      EXPECT_NEAR(x, p.x, 0.006);
      EXPECT_NEAR(h, p.height, 0.006);
      EXPECT_EQ(ignore, p.visible_fraction < 0.5F);
    }
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(WrittenFolder, HasNoKittiCalibrationForALensButRosOne) {
  SyntheticOptions options = small_street(2);
  options.lens = Lens::equidistant;
  options.distortion = {0.01, -0.002, 0.0003, -0.00004};
  write_kitti_folder(options, folder_.string());
  EXPECT_FALSE(fs::exists(folder_ / "calib.txt"));
  const auto read = open_sequence(folder_.string(), {});
  ASSERT_TRUE(read->info().camera);
  EXPECT_EQ(read->info().camera->lens, Lens::equidistant);
  EXPECT_NEAR(read->info().camera->distortion[3], -0.00004, 1e-12);
  fs::remove_all(folder_);

  options.lens = Lens::radial_tangential;
  options.distortion = {-0.2, 0.05, 0.001, -0.002, 0.003};
  write_kitti_folder(options, folder_.string());
  const auto bent = open_sequence(folder_.string(), {});
  EXPECT_EQ(bent->info().camera->lens, Lens::radial_tangential);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(bent->info().camera->distortion[i], options.distortion[i], 1e-12);
}

TEST_F(WrittenFolder, CanBeStoppedAndIsWholeUpToThere) {
  int calls = 0;
  EXPECT_EQ(write_kitti_folder(small_street(9), folder_.string(),
                               [&](int done, int all) {
                                 EXPECT_EQ(done, ++calls);
                                 EXPECT_EQ(all, 9);
                                 return done < 3;
                               }),
            3);
  EXPECT_EQ(open_sequence(folder_.string(), {})->info().groundtruth->T_w_c.size(), 3U);
}

/// The message of what writing throws.
std::string complaint(const fs::path& folder, const SyntheticOptions& options = small_street(2)) {
  try {
    write_kitti_folder(options, folder.string());
  } catch (const std::exception& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "no complaint";
}

TEST_F(WrittenFolder, RefusesAFolderThatHoldsSomething) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "precious.txt") << "precious";
  EXPECT_THAT(complaint(folder_), HasSubstr(folder_.string() + ": is not empty"));
  EXPECT_EQ(text("precious.txt"), "precious");
  EXPECT_THAT(complaint(folder_ / "precious.txt"), HasSubstr("precious.txt"));
  EXPECT_THAT(complaint(folder_ / "precious.txt" / "below"), HasSubstr("below: cannot make this folder"));
}

TEST_F(WrittenFolder, WritesNothingForBadOptions) {
  SyntheticOptions options = small_street(2);
  options.frames = -4;
  EXPECT_THAT(complaint(folder_, options), HasSubstr("frames is -4"));
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(WrittenFolder, NamesTheFileForWhichThereIsNoRoom) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  // a frame's file that leads to a device which is always full
  bool planted = false;
  try {
    write_kitti_folder(small_street(3), folder_.string(), [&](int, int) {
      if (!planted) fs::create_symlink("/dev/full", folder_ / "image_0" / "000001.png");
      planted = true;
      return true;
    });
    FAIL() << "a full disk went unnoticed";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr((folder_ / "image_0" / "000001.png").string()));
  }
}

}  // namespace
}  // namespace pavo
