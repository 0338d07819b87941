#include "stages/pose/essential.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "stages/pose/eight_point.h"
#include "tests/pose/scenes.h"

namespace pavo::test {
namespace {

std::vector<SE3> motions() {
  return {driving(), motion({0, 0, 0}, {0, 0, -1}),  // straight ahead
          motion({0, 0, 0}, {0, 0, 1}),              // backwards
          motion({0, -0.05, 0}, {0.7, 0, 0.1}),      // sideways
          motion({0.1, 0.02, 0.3}, {0, -0.5, 0.3})};
}

TEST(EssentialMatrix, SingularValuesAreRepaired) {
  const PointPairs pairs = pairs_of({.points = 100, .noise_px = 1});
  const Eigen::Matrix3d E = essential_from_fundamental(eight_point(pairs), kCamera);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E);
  EXPECT_NEAR(svd.singularValues()[0], 1, 1e-12);
  EXPECT_NEAR(svd.singularValues()[1], 1, 1e-12);
  EXPECT_NEAR(svd.singularValues()[2], 0, 1e-12);
}

TEST(EssentialMatrix, OneOfItsFourMotionsIsTheTrueOne) {
  for (const SE3& truth : motions()) {
    int hits = 0;
    for (const SE3& T : motions_of(essential_of(truth))) {
      EXPECT_TRUE(orthonormal(T.R));
      EXPECT_NEAR(T.t.norm(), 1, 1e-12);
      EXPECT_LT(std::min((essential_of(T) - essential_of(truth) / truth.t.norm()).norm(),
                         (essential_of(T) + essential_of(truth) / truth.t.norm()).norm()),
                1e-9);
      hits += degrees_between(T.R, truth.R) < 1e-5 && degrees_between(T.t, truth.t) < 1e-5;
    }
    EXPECT_EQ(hits, 1);
  }
}

TEST(EssentialMatrix, PointsInFrontChooseTheMotionThatOpenCVChooses) {
  for (const SE3& truth : motions()) {
    const PointPairs pairs = pairs_of({.points = 200, .noise_px = 0.1, .T_c_p = truth});
    const std::vector<std::uint8_t> use(pairs.size(), 1);
    const InFront chosen = motion_in_front(essential_of(truth), pairs, use, kCamera, 0.5);
    EXPECT_LT(degrees_between(chosen.T_c_p.R, truth.R), 1e-4);
    EXPECT_LT(degrees_between(chosen.T_c_p.t, truth.t), 1e-4);
    EXPECT_GT(chosen.in_front, 0.9 * chosen.asked);

    std::vector<cv::Point2f> previous, current;
    for (const PointPair& p : pairs) previous.emplace_back(p.x_previous, p.y_previous);
    for (const PointPair& p : pairs) current.emplace_back(p.x_current, p.y_current);
    const Eigen::Matrix3d E = essential_of(truth);
    const cv::Matx33d E_cv(E(0, 0), E(0, 1), E(0, 2), E(1, 0), E(1, 1), E(1, 2), E(2, 0), E(2, 1), E(2, 2));
    cv::Mat R, t;
    cv::recoverPose(E_cv, previous, current, R, t, kCamera.fx, {kCamera.cx, kCamera.cy});
    const Eigen::Vector3d t_cv(t.at<double>(0), t.at<double>(1), t.at<double>(2));
    EXPECT_LT(degrees_between(chosen.T_c_p.t, t_cv), 1e-3);
  }
}

TEST(EssentialMatrix, FarPointsDoNotTurnTheMotionAround) {
  // 95 % of the points are so far away that noise decides on which side of the camera they seem to be.
  Random random(3);
  const SE3 truth = motion({0, 0.002, 0}, {0, 0, -1});
  PointPairs pairs;
  while (pairs.size() < 400) {
    const double depth = pairs.size() < 20 ? 8 : 3000;
    const Eigen::Vector2d x(random.uniform() * kCamera.width, random.uniform() * kCamera.height);
    const Eigen::Vector2d y =
        project(truth * unproject(x.x(), x.y(), depth)) + 0.2 * Eigen::Vector2d(gauss(random), gauss(random));
    pairs.push_back(
        {static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(y.x()), static_cast<float>(y.y())});
  }
  const std::vector<std::uint8_t> use(pairs.size(), 1);
  EXPECT_LT(motion_in_front(essential_of(truth), pairs, use, kCamera, 1.0).T_c_p.t.z(), -0.99);
}

TEST(EssentialMatrix, TriangulatedDepthsAreTheTrueOnes) {
  const SE3 T = driving();
  const Eigen::Vector3d p(2, -1, 9);
  const Eigen::Vector3d q = T * p;
  const Depths depths = triangulate_depths(T, p / p.z(), q / q.z());
  EXPECT_NEAR(depths.previous, p.z(), 1e-9);
  EXPECT_NEAR(depths.current, q.z(), 1e-9);
  const Depths behind = triangulate_depths({T.R, -T.t}, p / p.z(), q / q.z());
  EXPECT_LT(behind.previous, 0);
}

TEST(EssentialMatrix, ParallaxIsWhatTheRotationLeaves) {
  const SE3 turn = motion({0, 0.05, 0}, {0, 0, 0});
  const Eigen::Vector2d y = project(turn * unproject(700, 100, 10));
  const PointPair pair{700, 100, static_cast<float>(y.x()), static_cast<float>(y.y() + 3)};
  EXPECT_NEAR(parallax_px(turn, pair, kCamera), 3, 1e-3);
}

}  // namespace
}  // namespace pavo::test
