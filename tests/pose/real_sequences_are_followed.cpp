// The recorded sequences, as far as they are needed to see that nothing is broken; the whole figures come from pavo
// eval.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "stages/features/extract.h"
#include "stages/pose/odometry.h"
#include "tests/pose/scenes.h"
#include "tests/support/data.h"

namespace pavo::test {
namespace {

namespace fs = std::filesystem;

struct Recording {
  Camera camera;
  std::vector<fs::path> images;
  std::vector<SE3> truth;
};

std::vector<fs::path> images_in(const fs::path& folder, std::size_t most) {
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(folder)) images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  images.resize(std::min(images.size(), most));
  return images;
}

Recording kitti(const fs::path& folder, const std::string& images, const std::string& projection, std::size_t most) {
  Recording recording;
  recording.images = images_in(folder / images, most);
  std::ifstream calibration(folder / "calib.txt");
  for (std::string name; calibration >> name;) {
    double p[12];
    for (double& value : p) calibration >> value;
    if (name == projection) recording.camera = {0, 0, p[0], p[5], p[2], p[6], Lens::rectified, {}};
  }
  std::ifstream poses(folder / "poses.txt");
  double p[12];
  while (recording.truth.size() < recording.images.size() && poses >> p[0]) {
    for (int i = 1; i < 12; ++i) poses >> p[i];
    SE3 pose;
    pose.R << p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10];
    pose.t << p[3], p[7], p[11];
    recording.truth.push_back(pose);
  }
  return recording;
}

Image read(const fs::path& path) {
  const cv::Mat gray = cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
  Image image(gray.cols, gray.rows);
  for (int y = 0; y < gray.rows; ++y) std::copy_n(gray.ptr(y), gray.cols, image.row(y));
  return image;
}

std::vector<PoseResult> follow(Recording& recording, std::shared_ptr<const StepLength> scale,
                               Tracker tracker = Tracker::descriptor) {
  cv::setNumThreads(0);
  Image images[2];
  Features features[2];
  std::vector<PoseResult> results(recording.images.size());
  std::unique_ptr<Odometry> odometry;
  std::unique_ptr<ExtractFeatures> extract;
  ExtractFeatures::Scratch scratch;
  for (std::size_t i = 0; i < recording.images.size(); ++i) {
    Image& image = images[i % 2];
    image = read(recording.images[i]);
    if (!odometry) {
      recording.camera.width = image.width();
      recording.camera.height = image.height();
      odometry = std::make_unique<Odometry>(recording.camera, OdometryOptions{.tracker = tracker}, scale);
      extract = std::make_unique<ExtractFeatures>(FeatureOptions{.max_features = 1500}, image.width(), image.height());
    }
    (*extract)(image, features[i % 2], scratch);
    const FrameView previous = i > 0 ? FrameView{&features[1 - i % 2], &images[1 - i % 2]} : FrameView{};
    const auto frame = static_cast<std::int64_t>(i);
    (*odometry)({frame, frame * 100000000, 0}, {&features[i % 2], &image}, previous, {}, results[i]);
  }
  return results;
}

std::shared_ptr<const StepLength> steps_of_truth(const Recording& recording) {
  Trajectory trajectory;
  trajectory.T_w_c = recording.truth;
  return std::make_shared<GroundtruthStep>(trajectory);
}

// Every frame has a pose of its own, ahead of the one before, and the end is where the truth ends.
void expect_followed(const Recording& recording, const std::vector<PoseResult>& results, double share_of_path) {
  double path = 0;
  for (std::size_t i = 1; i < results.size(); ++i) {
    EXPECT_EQ(results[i].quality, Quality::tracked) << i;
    EXPECT_GT((results[i - 1].T_w_c.inverse() * results[i].T_w_c).t.z(), 0) << "backwards at " << i;
    path += (recording.truth[i].t - recording.truth[i - 1].t).norm();
  }
  EXPECT_LT((results.back().T_w_c.t - recording.truth[results.size() - 1].t).norm(), share_of_path * path);
}

TEST(RealSequences, MotorwayIsNeverLostNorBackwards) {
  PAVO_NEEDS_DATA("sequences/kitti01-51");
  Recording recording = kitti(data_folder() / "sequences/kitti01-51", "image_0", "P0:", 51);
  expect_followed(recording, follow(recording, steps_of_truth(recording)), 0.02);
}

TEST(RealSequences, ResidentialTurn) {
  PAVO_NEEDS_DATA("sequences/kitti05-300");
  Recording recording = kitti(data_folder() / "sequences/kitti05-300", "image_0", "P0:", 40);
  expect_followed(recording, follow(recording, steps_of_truth(recording)), 0.02);
}

TEST(RealSequences, ResidentialWithTracks) {
  PAVO_NEEDS_DATA("sequences/kitti05-300");
  Recording recording = kitti(data_folder() / "sequences/kitti05-300", "image_0", "P0:", 15);
  expect_followed(recording, follow(recording, steps_of_truth(recording), Tracker::klt), 0.02);
}

void expect_still(const std::vector<PoseResult>& results) {
  for (const PoseResult& result : results) {
    EXPECT_TRUE(result.T_w_c.t.isZero(0));
    EXPECT_TRUE(result.T_w_c.R.isIdentity(0));
  }
}

TEST(RealSequences, PeopleWalkingPastMoveNothing) {
  PAVO_NEEDS_DATA("people/kitti17");
  Recording recording = kitti(data_folder() / "people/kitti17", "images", "P0:", 20);
  expect_still(follow(recording, std::make_shared<UnitStep>()));
}

TEST(RealSequences, SensorNoiseMovesNothing) {
  PAVO_NEEDS_DATA("sequences/euroc-standstill-25");
  const fs::path folder = data_folder() / "sequences/euroc-standstill-25/mav0/cam0/data";
  Recording recording{{0, 0, 458.654, 457.296, 367.215, 248.375, Lens::rectified, {}}, images_in(folder, 25), {}};
  // Distorted as they are: at rest a lens changes nothing.
  expect_still(follow(recording, std::make_shared<UnitStep>()));
}

}  // namespace
}  // namespace pavo::test
