// The homography of a plane, and the motions that it leaves: against the truth, and against OpenCV's.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <random>

#include "stages/pose/homography.h"

namespace pavo::test {
namespace {

const Camera kCamera{.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 320, .cy = 240};

struct Scene {
  SE3 T_c_p;
  Eigen::Vector3d m;  // the plane m.X = 1
  PointPairs pairs;
};

/// `outliers`: the share of pairs that have nothing to do with the plane.
Scene scene(std::uint32_t seed, double noise_px, double outliers) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> noise(0, noise_px + 1e-12);
  const auto direction = [&] { return Eigen::Vector3d(unit(random), unit(random), unit(random)); };
  Scene s;
  s.T_c_p = {Eigen::AngleAxisd(0.1 * unit(random), direction().normalized()).toRotationMatrix(),
             0.5 * direction().normalized()};
  s.m = Eigen::Vector3d(0.3 * unit(random), 0.3 * unit(random), 1) / 4;
  std::uniform_real_distribution<double> x(0, kCamera.width), y(0, kCamera.height);
  while (s.pairs.size() < 300) {
    const Eigen::Vector2d p(x(random), y(random));
    const Eigen::Vector3d ray((p.x() - kCamera.cx) / kCamera.fx, (p.y() - kCamera.cy) / kCamera.fy, 1);
    const Eigen::Vector3d q = s.T_c_p * (ray / s.m.dot(ray));
    Eigen::Vector2d c(kCamera.fx * q.x() / q.z() + kCamera.cx, kCamera.fy * q.y() / q.z() + kCamera.cy);
    if (static_cast<double>(s.pairs.size()) < 300 * outliers) c = {x(random), y(random)};
    s.pairs.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(c.x() + noise(random)),
                       static_cast<float>(c.y() + noise(random))});
  }
  return s;
}

Eigen::Matrix3d true_homography(const Scene& s) {
  return s.T_c_p.R + s.T_c_p.t * s.m.transpose();
}

/// Of a motion whose t has length 1 and whose sign is open.
double apart(const SE3& a, const SE3& b) {
  const Eigen::Vector3d t = b.t.normalized();
  return (a.R - b.R).norm() + std::min((a.t - t).norm(), (a.t + t).norm());
}

TEST(Homography, LeavesTheTrueMotion) {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const Scene s = scene(seed, 0, 0);
    const PlaneMotions motions = motions_of_homography(-3 * true_homography(s));
    double nearest = 10;
    for (int i = 0; i < motions.count; ++i) nearest = std::min(nearest, apart(motions.T_c_p[i], s.T_c_p));
    EXPECT_LT(nearest, 1e-6) << seed;
  }
}

TEST(Homography, LeavesTheMotionsThatOpenCvFinds) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const Eigen::Matrix3d H = true_homography(scene(seed, 0, 0));
    cv::Matx33d h;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) h(r, c) = H(r, c);
    std::vector<cv::Mat> Rs, ts, ns;
    cv::decomposeHomographyMat(h, cv::Matx33d::eye(), Rs, ts, ns);
    const PlaneMotions motions = motions_of_homography(H);
    ASSERT_EQ(motions.count, 2);
    for (std::size_t i = 0; i < Rs.size(); ++i) {
      SE3 theirs;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) theirs.R(r, c) = Rs[i].at<double>(r, c);
        theirs.t(r) = ts[i].at<double>(r);
      }
      EXPECT_LT(std::min(apart(motions.T_c_p[0], theirs), apart(motions.T_c_p[1], theirs)), 1e-5) << seed;
    }
  }
}

TEST(Homography, IsFoundAmongOutliers) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const Scene s = scene(seed, 0.3, 0.4);
    std::vector<std::uint8_t> is_inlier;
    const HomographyResult result = ransac_homography(s.pairs, kCamera, {}, Random(seed), is_inlier);
    ASSERT_TRUE(result.found) << seed;
    EXPECT_GE(result.inliers, 175) << seed;
    const Eigen::Matrix3d H = true_homography(s);
    EXPECT_LT((result.H / result.H(2, 2) - H / H(2, 2)).norm(), 0.01) << seed;
  }
}

TEST(Homography, OfARotationLeavesNoMotion) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_EQ(motions_of_homography(R).count, 0);
}

TEST(Homography, NeedsPairs) {
  std::vector<std::uint8_t> is_inlier;
  EXPECT_FALSE(ransac_homography({}, kCamera, {}, Random(1), is_inlier).found);
  const PointPairs same(50, PointPair{10, 10, 20, 20});
  EXPECT_FALSE(ransac_homography(same, kCamera, {}, Random(1), is_inlier).found) << "of one point only";
}

}  // namespace
}  // namespace pavo::test
