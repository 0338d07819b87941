// A few short drives of those that bench/consistency makes fifty of: the covariance grows from nothing, is one, and
// says about how far off the poses are.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <vector>

#include "drivers/synthetic/synthetic_street.h"
#include "pavo/keyframe_stages.h"
#include "pavo/plain_loop.h"
#include "stages/decode/decode.h"

namespace pavo::test {
namespace {

constexpr int kFrames = 30, kRuns = 3;

struct Drive {
  std::vector<Vector6d> errors;
  std::vector<Matrix6d> covariances;
};

Drive drive(std::uint64_t seed) {
  SyntheticOptions street;
  street.seed = seed;
  street.frames = kFrames;
  street.width = 320, street.height = 96;
  street.people = false;
  SyntheticStreet sequence(street);
  const SequenceInfo& info = sequence.info();
  PlainLoopOptions options;
  options.map.ground.emplace();
  options.map.ground->filter.height_m = street.camera_height_m;
  options.odometry.systematic.log_scale = kToldHeightLogSigma;
  PlainLoop loop(*info.camera, options, std::make_shared<UnknownStep>());
  const Decode decode(street.width, street.height);
  Decode::Scratch scratch;
  EncodedImage encoded;
  Image image;
  Drive made;
  for (FrameStamp stamp; sequence.read(encoded, stamp);) {
    decode(encoded, image, scratch);
    const PoseResult& pose = loop({.index = stamp.index, .t_ns = stamp.t_capture_ns}, image, {});
    EXPECT_TRUE(pose.has_covariance);
    made.errors.push_back(step_between(pose.T_w_c, info.groundtruth->T_w_c[made.errors.size()]));
    made.covariances.push_back(pose.covariance);
  }
  return made;
}

const std::vector<Drive>& drives() {
  static const std::vector<Drive> all = [] {
    std::vector<Drive> d;
    for (int seed = 1; seed <= kRuns; ++seed) d.push_back(drive(static_cast<std::uint64_t>(seed)));
    return d;
  }();
  return all;
}

TEST(Covariance, BeginsAtNothingAndStaysOne) {
  for (const Drive& d : drives()) {
    EXPECT_EQ(d.covariances[0], Matrix6d::Zero());
    for (std::size_t k = 1; k < d.covariances.size(); ++k) {
      const Matrix6d& C = d.covariances[k];
      EXPECT_EQ(C, C.transpose());
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(C).eigenvalues().minCoeff(), 0) << k;
    }
    const auto turned = [&](std::size_t k) { return d.covariances[k].diagonal().tail(3).sum(); };
    EXPECT_GT(turned(kFrames - 1), turned(1));
  }
}

// 3 drives, frames that hang together: 18 numbers of chi-square, so 95 % are in 2.7 to 10.5; beyond twice that, the
// covariance is of something else.
TEST(Covariance, SaysHowFarOffThePosesAre) {
  double sum = 0;
  int count = 0;
  for (const Drive& d : drives()) {
    for (std::size_t k = 10; k < kFrames; k += 5, ++count)
      sum += d.errors[k].dot(d.covariances[k].ldlt().solve(d.errors[k]));
  }
  EXPECT_GT(sum / count, 1.5);
  EXPECT_LT(sum / count, 20);
}

}  // namespace
}  // namespace pavo::test
