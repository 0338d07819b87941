#include <cmath>

#include "tests/synthetic/support.h"
#include "types/lens.h"

namespace pavo {
namespace {

using test::Gray;
using test::read_all;
using test::small_street;

SyntheticOptions empty_street(int frames) {
  SyntheticOptions options = small_street(frames);
  options.people = false;
  return options;
}

/// Mean difference on the road before the camera between frame `next` and frame `k` carried over by `T_next_k`.
double road_difference(const SyntheticStreet& street, const std::vector<Gray>& frames, int k, const SE3& T_k_next) {
  const Camera& camera = *street.info().camera;
  const SE3& T_w_next = street.info().groundtruth->T_w_c[static_cast<std::size_t>(k + 1)];
  const Gray &a = frames[static_cast<std::size_t>(k)], &b = frames[static_cast<std::size_t>(k + 1)];
  double sum = 0;
  int n = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = *unproject(camera, {x, y}), down = street.road_normal();
      const double depth = (street.road_height() - down.dot(T_w_next.t)) / down.dot(T_w_next.R * ray);
      const Eigen::Vector3d point = depth * ray;
      if (!(depth > 0) || point.z() > 14 || std::abs(point.x()) > 1.5) continue;
      const Eigen::Vector2d from = project(camera, T_k_next * point);
      if (!a.covers(from.x(), from.y())) continue;
      sum += std::abs(a.between(from.x(), from.y()) - b.at(x, y));
      ++n;
    }
  }
  EXPECT_GT(n, 300);
  return sum / n;
}

TEST(SyntheticGroundTruth, CarriesTheRoadFromOneFrameToTheNext) {
  SyntheticStreet street(empty_street(8));
  const auto frames = read_all(street);
  const auto& T = street.info().groundtruth->T_w_c;
  double right = 0, still = 0, tilted = 0;
  SE3 tilt;  // a degree is more than any error of ours
  tilt.R << 1, 0, 0, 0, std::cos(0.017), -std::sin(0.017), 0, std::sin(0.017), std::cos(0.017);
  for (int k = 0; k < 7; ++k) {
    const SE3 T_k_next = T[static_cast<std::size_t>(k)].inverse() * T[static_cast<std::size_t>(k + 1)];
    right += road_difference(street, frames, k, T_k_next);
    still += road_difference(street, frames, k, SE3{});
    tilted += road_difference(street, frames, k, tilt * T_k_next);
  }
  EXPECT_LT(right / 7, 4.5) << "gray levels";
  EXPECT_LT(right, 0.6 * still);
  EXPECT_LT(right, 0.6 * tilted);
}

TEST(SyntheticGroundTruth, StartsAtTheIdentityAndConsistsOfRotations) {
  const SyntheticStreet street(empty_street(300));
  const auto& truth = *street.info().groundtruth;
  ASSERT_EQ(truth.T_w_c.size(), 300U);
  ASSERT_EQ(truth.t_ns.size(), 300U);
  EXPECT_TRUE(truth.T_w_c[0].R.isIdentity(0));
  EXPECT_TRUE(truth.T_w_c[0].t.isZero(0));
  for (std::size_t k = 1; k < truth.T_w_c.size(); ++k) {
    const SE3& pose = truth.T_w_c[k];
    EXPECT_LT((pose.R.transpose() * pose.R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
    const SE3 motion = truth.T_w_c[k - 1].inverse() * pose;
    EXPECT_NEAR(motion.t.norm(), 0.8, 0.17);  // less on the inside of a bend, more on its outside
    EXPECT_GT(motion.t.z(), 0.6);             // ahead
    EXPECT_GT(truth.t_ns[k], truth.t_ns[k - 1]);
  }
}

TEST(SyntheticGroundTruth, TurnsOnceByARightAngleInTheDemo) {
  for (const std::uint64_t seed : {1ULL, 2ULL, 3ULL}) {
    SyntheticOptions options = empty_street(300);
    options.seed = seed;
    const SyntheticStreet street(options);
    const Eigen::Vector3d ahead = street.info().groundtruth->T_w_c.back().R.col(2);
    const double heading = std::abs(std::atan2(ahead.x(), ahead.z())) * 180 / 3.14159265;
    EXPECT_NEAR(heading, 90, 12) << "seed " << seed;
  }
}

TEST(SyntheticGroundTruth, CarriesTheRoadOverHills) {
  constexpr std::size_t kFrames = 57, kFirst = 52;
  SyntheticOptions options = empty_street(kFrames);
  options.hills_m = 4;
  SyntheticStreet street(options);
  const auto& T = street.info().groundtruth->T_w_c;
  double highest = 0;
  for (const SE3& pose : T) highest = std::max(highest, -pose.t.dot(street.road_normal()));
  EXPECT_NEAR(highest, 2, 0.4) << "half way to the top";

  // Half way up the road before the camera is even for the 10 m that are looked at, and has another slope than at
  // the start: what the truth says of both has to carry one frame into the next.
  for (std::size_t k = 0; k < kFirst; ++k) street.skip();
  const auto frames = read_all(street);
  const Camera& camera = *street.info().camera;
  double right = 0, as_level = 0;
  int n = 0;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    const std::size_t k = kFirst + i;
    const SE3 T_k_next = T[k].inverse() * T[k + 1];
    // The camera keeps its height above the road and looks along it, but for a wobble of some milliradians.
    const Eigen::Vector3d along_road(0, 1, 0), level = T[k + 1].R.transpose() * street.road_normal();
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Vector3d ray = *unproject(camera, {x, y});
        const auto difference = [&](const Eigen::Vector3d& down, double& sum) {
          const Eigen::Vector3d point = street.road_height() / down.dot(ray) * ray;
          if (!(point.z() > 0) || point.z() > 10 || std::abs(point.x()) > 1.5) return false;
          const Eigen::Vector2d from = project(camera, T_k_next * point);
          if (!frames[i].covers(from.x(), from.y())) return false;
          sum += std::abs(frames[i].between(from.x(), from.y()) - frames[i + 1].at(x, y));
          return true;
        };
        double with = 0, without = 0;
        if (!difference(along_road, with) || !difference(level, without)) continue;
        right += with, as_level += without, ++n;
      }
    }
  }
  ASSERT_GT(n, 1000);
  EXPECT_LT(right / n, 5) << "gray levels";
  EXPECT_LT(right, 0.8 * as_level);
}

TEST(SyntheticGroundTruth, ACameraThatStandsStillHasTheSamePoseAndTheSamePicture) {
  SyntheticOptions options = empty_street(7);
  options.standstills = {{3, 2}};
  SyntheticStreet street(options);
  const auto frames = read_all(street);
  const auto& T = street.info().groundtruth->T_w_c;
  for (const std::size_t k : {3U, 4U}) {
    EXPECT_EQ(T[k].R, T[2].R);
    EXPECT_EQ(T[k].t, T[2].t);
    EXPECT_EQ(frames[k].pixels, frames[2].pixels);
  }
  EXPECT_NE(T[5].t, T[4].t);
  EXPECT_NE(frames[3].pixels, frames[1].pixels);
}

TEST(SyntheticGroundTruth, ALoopComesBackToWhereItBegan) {
  SyntheticOptions options = empty_street(1400);
  options.loop = true;
  SyntheticStreet street(options);
  const auto& T = street.info().groundtruth->T_w_c;
  double nearest = 1e9, turned = 0;
  std::size_t back = 0;
  for (std::size_t k = 300; k < T.size(); ++k) {
    if (T[k].t.norm() >= nearest) continue;
    nearest = T[k].t.norm();
    back = k;
  }
  for (std::size_t k = 1; k <= back; ++k) {
    const Eigen::Vector3d ahead = (T[k - 1].R.transpose() * T[k].R).col(2);
    turned += std::atan2(ahead.x(), ahead.z());
  }
  EXPECT_LT(nearest, 1.0);
  EXPECT_LT((T[back].R.col(2) - T[0].R.col(2)).norm(), 0.1);
  EXPECT_NEAR(std::abs(turned) / (2 * 3.14159265), std::round(std::abs(turned) / (2 * 3.14159265)), 0.02);
}

TEST(SyntheticGroundTruth, ALensBendsThePictureAndNothingElse) {
  SyntheticOptions options = empty_street(1);
  options.fx = 185;
  const auto straight = test::render(options);
  const Camera ideal = synthetic_camera(options);
  for (const bool fisheye : {false, true}) {
    options.lens = fisheye ? Lens::equidistant : Lens::radial_tangential;
    options.distortion =
        fisheye ? std::array<double, 8>{-0.01, 0.004} : std::array<double, 8>{-0.28, 0.08, 0.001, -0.0005};
    SyntheticStreet street(options);
    const auto bent = read_all(street);
    double sum = 0, unmoved = 0;
    int n = 0;
    for (int y = 4; y < 92; ++y) {
      for (int x = 4; x < 316; ++x) {
        const auto ray = unproject(*street.info().camera, {x, y});
        if (!ray || ray->z() < 0.1) continue;
        const Eigen::Vector2d from = project(ideal, *ray);
        if (!straight[0].covers(from.x(), from.y())) continue;
        sum += std::abs(straight[0].between(from.x(), from.y()) - bent[0].at(x, y));
        unmoved += std::abs(straight[0].at(x, y) - bent[0].at(x, y));
        ++n;
      }
    }
    ASSERT_GT(n, 15000);
    EXPECT_LT(sum / n, 7) << fisheye;
    EXPECT_LT(sum, 0.6 * unmoved) << fisheye;
  }
}

}  // namespace
}  // namespace pavo
