// What a calibration leaves over is learnt while driving, and does not become a drift of scale.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>

#include "stages/map/local_map.h"
#include "tests/keyframe/street_of_points.h"

namespace pavo::test {
namespace {

const LensError kError(-0.004, 0.012);

TEST(RefinedCamera, IsTheCalibratedOneWithoutError) {
  const Eigen::Vector3d p(0.3, -0.2, 1.5);
  EXPECT_EQ(pixel_of(refined_camera(kCamera, LensError::Zero()), p), pixel_of(kCamera, p));
}

TEST(RefinedCamera, GivesTheRayOfAPixelBack) {
  for (const double k1 : {-0.03, 0.0, 0.03}) {
    const Camera camera = refined_camera(kCamera, {0.01, k1});
    for (int v = 0; v < camera.height; v += 37)
      for (int u = 0; u < camera.width; u += 41)
        EXPECT_LT((pixel_of(camera, ray_of(camera, u, v)) - Eigen::Vector2d(u, v)).norm(), 1e-4) << u << ' ' << v;
  }
}

TEST(RefinedCamera, HasTheJacobiansOfItsProjection) {
  constexpr double h = 1e-6;
  const Eigen::Vector3d p(0.7, -0.3, 1.2);
  const auto pixel = [&](const LensError& e, const Eigen::Vector3d& at) {
    return pixel_of(refined_camera(kCamera, e), at);
  };
  for (const LensError& error : {kError, LensError(0.01, -0.03)}) {
    const Camera camera = refined_camera(kCamera, error);
    const auto by_point = pixel_jacobian(camera, p);
    const auto by_lens = lens_jacobian(camera, p);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
      EXPECT_LT(((pixel(error, p + step) - pixel(error, p - step)) / (2 * h) - by_point.col(k)).norm(), 1e-3) << k;
    }
    for (int k = 0; k < 2; ++k) {
      const LensError step = h * LensError::Unit(k);
      EXPECT_LT(((pixel(error + step, p) - pixel(error - step, p)) / (2 * h) - by_lens.col(k)).norm(), 1e-3) << k;
    }
  }
}

/// What the street looks like through a lens that is not what it was calibrated to be.
void look_through(const LensError& error, Bundle& bundle) {
  const Camera camera = refined_camera(kCamera, error);
  for (BundleObservation& z : bundle.observations) {
    const Eigen::Vector2d x = pixel_of(camera, ray_of(kCamera, z.x, z.y));
    z.x = x.x(), z.y = x.y();
  }
}

TEST(BundleAdjustment, FindsTheErrorOfTheCalibration) {
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    StreetOfPoints street = street_of_points(seed, 10, 600, 0.4);
    look_through(kError, street.bundle);
    const Eigen::Vector2d sigma(0.01, 0.03);
    street.bundle.lens_information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    BundleOptions options;
    options.iterations = 20;
    BundleAdjustment adjust(kCamera, options);
    const BundleSummary summary = adjust(street.bundle);
    const LensError off = street.bundle.lens - kError;
    EXPECT_LT(off.dot(summary.lens_information * off), 16) << seed << ": " << street.bundle.lens.transpose();
    const Eigen::Matrix2d covariance = summary.lens_information.inverse();
    EXPECT_LT(covariance(1, 1), 0.25 * sigma(1) * sigma(1)) << "the points say nothing of it";
    EXPECT_NEAR(adjust.cost(street.bundle), summary.final_cost, 1e-9 * summary.final_cost);
  }
}

TEST(BundleAdjustment, LeavesTheCalibrationAloneThatIsSure) {
  StreetOfPoints street = street_of_points(1, 8, 80, 0.4);
  look_through(kError, street.bundle);
  BundleAdjustment adjust(kCamera, {});
  const BundleSummary summary = adjust(street.bundle);
  EXPECT_TRUE(street.bundle.lens.isZero(0));
  EXPECT_TRUE(summary.lens_information.isZero(0));
}

/// Drives through points with a window of keyframes, as the odometry would tell it. Every keyframe's motion is told
/// with the scale that the map has of it.
class Drive {
 public:
  Drive(const LocalMapOptions& options, const LensError& error)
      : map(kCamera, options), camera_(refined_camera(kCamera, error)) {}

  void go(int keyframes) {
    const SE3 step = motion({0, 0, 0}, {0, 0, 0.7});
    for (int n = 0; n < keyframes; ++n) {
      const SE3 before = T_;
      if (frame_ > 0) T_ = T_ * step;
      KeyframeRecord record;
      record.is_keyframe = record.followed = true;
      record.restart = frame_ == 0;
      record.frame = frame_;
      record.T_last_c = frame_ == 0 ? SE3{} : before.inverse() * T_;
      see(record);
      map.add(record);
      ++frame_;
    }
  }

  LocalMap map;

 private:
  void see(KeyframeRecord& record) {
    while (points_.size() < 300) {
      const Eigen::Vector3d in_camera(30 * random_.uniform() - 15, 6 * random_.uniform() - 4.5,
                                      8 + 40 * random_.uniform());
      points_[next_++] = T_ * in_camera;
    }
    for (auto it = points_.begin(); it != points_.end();) {
      const Eigen::Vector3d p = T_.inverse() * it->second;
      const Eigen::Vector2d x = p.z() > 1 ? pixel_of(camera_, p) : Eigen::Vector2d(-1, -1);
      if (!inside(x)) {
        it = points_.erase(it);
        continue;
      }
      const Eigen::Vector2d seen = x + 0.2 * Eigen::Vector2d(gauss(random_), gauss(random_));
      if (!known_[it->first]) {
        known_[it->first] = true;
        const Camera believed = refined_camera(kCamera, map.lens());
        record.new_points.push_back({it->first,
                                     {Eigen::Vector3d::Zero(), ray_of(believed, seen.x(), seen.y()),
                                      1 / p.z() * (1 + 0.1 * gauss(random_)), 0.05}});
      }
      record.observations.push_back({it->first, static_cast<float>(seen.x()), static_cast<float>(seen.y()), 0.4f});
      ++it;
    }
  }

  Camera camera_;
  Random random_{7};
  SE3 T_;
  std::map<PointId, Eigen::Vector3d> points_;
  std::map<PointId, bool> known_;
  PointId next_ = 1;
  std::int64_t frame_ = 0;
};

TEST(LocalMap, LearnsTheErrorOfTheCalibration) {
  Drive drive({}, kError);
  drive.go(100);
  EXPECT_NEAR(drive.map.lens()(1), kError(1), 0.003);
}

TEST(LocalMap, FindsNoErrorWhereThereIsNone) {
  Drive drive({}, LensError::Zero());
  drive.go(40);
  EXPECT_NEAR(drive.map.lens()(0), 0, 0.003);
  EXPECT_NEAR(drive.map.lens()(1), 0, 0.001);
}

TEST(LocalMap, LeavesTheCalibrationAloneWhereItIsTold) {
  LocalMapOptions options;
  options.refine_lens = false;
  Drive drive(options, kError);
  drive.go(15);
  EXPECT_TRUE(drive.map.lens().isZero(0));
}

// The second map of a run knows what the first has learnt.
TEST(LocalMap, KeepsWhatItLearntOverARestart) {
  Drive drive({}, kError);
  drive.go(30);
  const LensError learnt = drive.map.lens();
  KeyframeRecord restart;
  restart.is_keyframe = restart.restart = true;
  restart.frame = 100;
  drive.map.add(restart);
  EXPECT_EQ(drive.map.lens(), learnt);
}

}  // namespace
}  // namespace pavo::test
