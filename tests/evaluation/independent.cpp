// The measures against other implementations: Eigen's Umeyama, a search by brute force, 4x4 matrices written out.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "tests/evaluation/paths.h"

namespace pavo {
namespace {

using namespace test;

Eigen::Matrix3Xd positions(const std::vector<SE3>& poses) {
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) all.col(static_cast<Eigen::Index>(i)) = poses[i].t;
  return all;
}

Eigen::Matrix4d matrix(const SE3& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.R;
  m.topRightCorner<3, 1>() = pose.t;
  return m;
}

TEST(Alignment, IsEigensUmeyama) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Trajectory truth = wandering(60, seed), estimate = disturbed(truth, seed + 100, 0.3);
    const PosePairs pairs = pairs_of(estimate, truth);
    for (const bool with_scale : {false, true}) {
      const Eigen::Matrix4d expected = Eigen::umeyama(positions(estimate.T_w_c), positions(truth.T_w_c), with_scale);
      const Similarity S = align(pairs, with_scale ? Alignment::sim3 : Alignment::se3);
      EXPECT_TRUE((S.scale * S.R).isApprox(expected.topLeftCorner<3, 3>(), 1e-9));
      EXPECT_TRUE(S.t.isApprox(expected.topRightCorner<3, 1>(), 1e-7));
      EXPECT_EQ(S.scale_known, with_scale);
    }
  }
}

TEST(Alignment, IsTheBestOfItsNeighbours) {
  const Trajectory truth = wandering(80, 5), estimate = disturbed(truth, 6, 2);
  const PosePairs pairs = pairs_of(estimate, truth);
  for (const Alignment a : {Alignment::se3, Alignment::sim3, Alignment::scale}) {
    const Similarity best = align(pairs, a);
    const double rmse = absolute_errors_m(pairs, best).rmse;
    for (int axis = 0; axis < 3 && a != Alignment::scale; ++axis) {
      for (const double change : {-1e-3, 1e-3}) {
        Similarity other = best;
        other.t(axis) += change;
        EXPECT_GT(absolute_errors_m(pairs, other).rmse, rmse);
        other = best;
        other.R = Eigen::AngleAxisd(change, Eigen::Vector3d::Unit(axis)).toRotationMatrix() * best.R;
        EXPECT_GT(absolute_errors_m(pairs, other).rmse, rmse);
      }
    }
    for (const double factor : {0.999, 1.001}) {
      if (a == Alignment::se3) continue;
      Similarity other = best;  // about the first pose, where that is what the alignment keeps
      const Eigen::Vector3d pivot = a == Alignment::scale ? estimate.T_w_c[0].t : Eigen::Vector3d::Zero();
      other.t = best * pivot - factor * best.scale * (best.R * pivot);
      other.scale *= factor;
      EXPECT_GT(absolute_errors_m(pairs, other).rmse, rmse);
    }
  }
}

TEST(Alignment, UndoesAnySimilarity) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Trajectory truth = wandering(30, seed);
    Similarity S;
    S.scale = std::pow(10.0, static_cast<int>(seed % 7) - 3);
    S.R = Eigen::Quaterniond(1, 0.1 * seed, -0.3, 0.2 * seed).normalized().toRotationMatrix();
    S.t = {1.0 * seed, -2, 3};
    const PosePairs pairs = pairs_of(moved(S, truth), truth);
    const Similarity back = align(pairs, Alignment::sim3);
    EXPECT_NEAR(back.scale * S.scale, 1, 1e-9);
    EXPECT_TRUE(back.R.isApprox(S.R.transpose(), 1e-9));
    EXPECT_LT(absolute_errors_m(pairs, back).max, 1e-9);
  }
}

TEST(Alignment, OfAMirroredPathIsStillARotation) {
  const Trajectory truth = wandering(50, 9);
  Trajectory mirrored = truth;
  for (SE3& pose : mirrored.T_w_c) pose.t.x() = -pose.t.x();
  EXPECT_NEAR(align(pairs_of(mirrored, truth), Alignment::sim3).R.determinant(), 1, 1e-12);
}

TEST(SegmentErrors, AreThoseOfKittisRuleWrittenOut) {
  const Trajectory truth = wandering(400, 11), estimate = disturbed(truth, 12, 0.9);
  const PosePairs pairs = pairs_of(estimate, truth);
  const double lengths[] = {37, 100, 250};
  for (const int step : {1, 7, 10}) {
    const SegmentErrorsByLength errors = segment_errors(pairs, 1.1, lengths, step);
    double all_t = 0, all_r = 0;
    double all = 0;
    for (std::size_t l = 0; l < 3; ++l) {
      double sum_t = 0, sum_r = 0;
      double n = 0;
      for (std::size_t first = 0; first < truth.T_w_c.size(); first += static_cast<std::size_t>(step)) {
        double way = 0;
        std::size_t last = first;
        while (way <= lengths[l] && ++last < truth.T_w_c.size())
          way += (truth.T_w_c[last].t - truth.T_w_c[last - 1].t).norm();
        if (last == truth.T_w_c.size()) continue;
        Eigen::Matrix4d e = (matrix(estimate.T_w_c[first]).inverse() * matrix(estimate.T_w_c[last])).eval();
        e.topRightCorner<3, 1>() *= 1.1;
        const Eigen::Matrix4d error = e.inverse() * matrix(truth.T_w_c[first]).inverse() * matrix(truth.T_w_c[last]);
        sum_t += error.topRightCorner<3, 1>().norm() / lengths[l];
        sum_r += std::acos(std::clamp((error.topLeftCorner<3, 3>().trace() - 1) / 2, -1.0, 1.0)) / lengths[l];
        ++n;
      }
      ASSERT_TRUE(errors.lengths[l].errors);
      EXPECT_EQ(static_cast<double>(errors.lengths[l].errors->segments), n);
      EXPECT_NEAR(errors.lengths[l].errors->t_rel_percent, 100 * sum_t / n, 1e-9);
      EXPECT_NEAR(errors.lengths[l].errors->r_rel_deg_per_100m, 100 * sum_r / n * 180 / std::numbers::pi, 1e-6);
      all_t += sum_t, all_r += sum_r, all += n;
    }
    EXPECT_EQ(static_cast<double>(errors.all->segments), all);
    EXPECT_NEAR(errors.all->t_rel_percent, 100 * all_t / all, 1e-9);
    EXPECT_NEAR(errors.all->r_rel_deg_per_100m, 100 * all_r / all * 180 / std::numbers::pi, 1e-6);
  }
}

TEST(ParameterErrors, AreThoseOfEveryMatrixEntry) {
  const Trajectory truth = wandering(40, 21), estimate = disturbed(truth, 22, 1.3);
  const PosePairs pairs = pairs_of(estimate, truth);
  Eigen::Matrix4d poses = Eigen::Matrix4d::Zero(), motions = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < 40; ++i) {
    Eigen::Matrix4d e = matrix(estimate.T_w_c[0]).inverse() * matrix(estimate.T_w_c[i]);
    e.topRightCorner<3, 1>() *= 0.7;
    poses += (e - matrix(truth.T_w_c[0]).inverse() * matrix(truth.T_w_c[i])).cwiseAbs2() / 40;
    if (i == 0) continue;
    e = matrix(estimate.T_w_c[i - 1]).inverse() * matrix(estimate.T_w_c[i]);
    e.topRightCorner<3, 1>() *= 0.7;
    motions += (e - matrix(truth.T_w_c[i - 1]).inverse() * matrix(truth.T_w_c[i])).cwiseAbs2() / 39;
  }
  EXPECT_TRUE(pose_rmse(pairs, 0.7).isApprox(poses.cwiseSqrt().topRows<3>(), 1e-9));
  EXPECT_TRUE(motion_rmse(pairs, 0.7).isApprox(motions.cwiseSqrt().topRows<3>(), 1e-9));
}

TEST(RotationAngle, IsThatOfTheAxisAndOutlivesRounding) {
  for (const double angle : {0.0, 1e-12, 1e-6, 0.1, 1.5, 3.0, std::numbers::pi}) {
    const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    EXPECT_NEAR(rotation_angle_rad(R), angle, 1e-12 + 1e-9 * (angle > 3));
  }
  const Eigen::Matrix3d rounded = Eigen::Matrix3d::Identity() * (1 - 1e-7);
  EXPECT_EQ(rotation_angle_rad(rounded), 0) << "acos would say 5e-4";
}

TEST(Statistics, AreThoseOfTheList) {
  const Statistics s = statistics({3, 1, 2, 10});
  EXPECT_EQ(s.mean, 4);
  EXPECT_EQ(s.median, 2.5);
  EXPECT_EQ(s.max, 10);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(114.0 / 4));
  EXPECT_EQ(statistics({3, 1, 2}).median, 2);
}

}  // namespace
}  // namespace pavo
