#include <gtest/gtest.h>

#include <numbers>

#include "tests/undistort/cameras.h"
#include "types/lens.h"

namespace pavo::test {
namespace {

TEST(Lens, ProjectsBackToThePixelThatItLookedThrough) {
  for (const auto& [name, camera] : cameras())
    for (int y = 0; y < camera.height; y += 7)
      for (int x = 0; x < camera.width; x += 7) {
        const std::optional<Eigen::Vector3d> ray = unproject(camera, {x, y});
        if (!ray) continue;
        EXPECT_NEAR(ray->norm(), 1, 1e-12);
        EXPECT_LT((project(camera, *ray) - Eigen::Vector2d(x, y)).norm(), 1e-5) << name << " at " << x << ", " << y;
      }
}

TEST(Lens, FindsTheRayThatWasProjected) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> side(-0.5, 0.5);
  for (const auto& [name, camera] : cameras()) {
    const double limit = lens_limit(camera);
    for (int n = 0; n < 200; ++n) {
      const Eigen::Vector3d ray = Eigen::Vector3d(side(random), side(random), 1).normalized();
      if (ray.head<2>().norm() / ray.z() > 0.9 * limit) continue;
      const std::optional<Eigen::Vector3d> back = unproject(camera, project(camera, ray));
      ASSERT_TRUE(back) << name;
      EXPECT_LT((*back - ray).norm(), 1e-7) << name;
    }
  }
}

TEST(Lens, EquidistantSeesSideways) {
  const Camera camera{600, 600, 150, 150, 300, 300, Lens::equidistant, {}};
  const Eigen::Vector2d pixel = project(camera, {1, 0, 0});
  EXPECT_NEAR(pixel.x(), 300 + 150 * std::numbers::pi / 2, 1e-9);
  const std::optional<Eigen::Vector3d> ray = unproject(camera, {300 + 150 * 2.0, 300});  // 2 rad: behind
  ASSERT_TRUE(ray);
  EXPECT_NEAR(ray->z(), std::cos(2.0), 1e-9);
  EXPECT_FALSE(unproject(camera, {300 + 150 * 3.2, 300}));  // beyond a half turn
}

TEST(Lens, KnowsWhereTheFormulaTurnsBack) {
  Camera camera{640, 480, 400, 400, 320, 240, Lens::radial_tangential, {-0.3}};
  EXPECT_NEAR(lens_limit(camera), 1 / std::sqrt(0.9), 0.003);  // 1 - 0.9 r^2 = 0
  EXPECT_FALSE(unproject(camera, {320 + 400 * 0.75, 240}));    // r (1 - 0.3 r^2) is 0.703 at most
  EXPECT_TRUE(unproject(camera, {320 + 400 * 0.69, 240}));
  camera.distortion[0] = 0.3;
  EXPECT_EQ(lens_limit(camera), std::numeric_limits<double>::infinity());
  camera.lens = Lens::rectified;
  EXPECT_EQ(distort(camera, {0.3, 0.4}), Eigen::Vector2d(0.3, 0.4));
}

TEST(Lens, OfAFisheyeTheMiddleIsNoSpecialCase) {
  const Camera camera{600, 600, 150, 150, 300, 300, Lens::equidistant, {0.01, 0.02, 0.03, 0.004}};
  EXPECT_EQ(distort(camera, {0, 0}), Eigen::Vector2d(0, 0));
  EXPECT_LT((distort(camera, {1e-9, 0}) - Eigen::Vector2d(1e-9, 0)).norm(), 1e-15);
  const std::optional<Eigen::Vector3d> ray = unproject(camera, {300, 300});
  ASSERT_TRUE(ray);
  EXPECT_EQ(*ray, Eigen::Vector3d(0, 0, 1));
}

}  // namespace
}  // namespace pavo::test
