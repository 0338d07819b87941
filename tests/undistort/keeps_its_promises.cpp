#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "stages/undistort/undistort.h"
#include "tests/support/simd_targets.h"
#include "tests/undistort/cameras.h"
#include "types/lens.h"

namespace pavo::test {
namespace {

bool same(const Image& a, const Image& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (int y = 0; y < a.height(); ++y)
    if (!std::equal(a.row(y), a.row(y) + a.width(), b.row(y))) return false;
  return true;
}

TEST(Undistort, WithoutDistortionIsTheIdentity) {
  for (const Lens lens : {Lens::rectified, Lens::radial_tangential}) {
    const Undistort undistort(Camera{101, 67, 80, 80, 50, 33, lens, {}});
    const Image raw = noise(101, 67, 1);
    Image image;
    undistort(raw, image);
    EXPECT_TRUE(same(raw, image));
    EXPECT_EQ(undistort.valid_mask().at(0, 0), 255);
    EXPECT_EQ(undistort.valid_mask().at(100, 66), 255);
  }
}

/// The maps themselves, too: a distortion of nearly nothing takes the general way.
TEST(Undistort, WithNearlyNoDistortionIsNearlyTheIdentity) {
  const Undistort undistort(Camera{101, 67, 80, 80, 50, 33, Lens::radial_tangential, {1e-9}});
  const Image raw = noise(101, 67, 1);
  Image image;
  undistort(raw, image);
  for (int y = 0; y < 67; ++y)
    for (int x = 0; x < 101; ++x)
      if (undistort.valid_mask().at(x, y) == 255) {
        EXPECT_NEAR(image.at(x, y), raw.at(x, y), y == 66 ? 2 : 0);
      }
}

TEST(Undistort, KeepsKAndSaysSo) {
  for (const auto& [name, camera] : cameras()) {
    const Camera rectified = Undistort(camera).rectified_camera();
    EXPECT_EQ(rectified.lens, Lens::rectified);
    EXPECT_EQ(rectified.fx, camera.fx);
    EXPECT_EQ(rectified.cy, camera.cy);
    EXPECT_EQ(rectified.width, camera.width);
    EXPECT_EQ(rectified.distortion, (std::array<double, 8>{}));
  }
}

TEST(Undistort, ShowsTheWholeSourceWithAlphaOne) {
  for (const auto& [name, camera] : cameras()) {
    if (camera.lens == Lens::equidistant) continue;  // 80 degrees are the limit
    const Camera wide = Undistort(camera, 1).rectified_camera();
    for (int y = 0; y < camera.height; y += 11)
      for (int x = 0; x < camera.width; x += 11) {
        const std::optional<Eigen::Vector3d> ray = unproject(camera, {x, y});
        if (!ray) continue;
        const Eigen::Vector2d seen = project(wide, *ray);
        EXPECT_TRUE(seen.x() > -0.01 && seen.y() > -0.01 && seen.x() < camera.width - 0.99 &&
                    seen.y() < camera.height - 0.99)
            << name << ": " << x << ", " << y << " is at " << seen.transpose();
      }
  }
}

TEST(Undistort, MasksWhatTheSourceDoesNotShow) {
  for (const auto& [name, camera] : cameras())
    for (const double alpha : {0.0, 1.0}) {
      const Undistort undistort(camera, alpha);
      Image white(camera.width, camera.height), image;
      for (int y = 0; y < camera.height; ++y) std::fill_n(white.row(y), camera.width, std::uint8_t{255});
      undistort(white, image);
      const Camera rectified = undistort.rectified_camera();
      const double limit = lens_limit(camera);
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
          const std::uint8_t valid = undistort.valid_mask().at(x, y);
          ASSERT_TRUE(valid == 0 || valid == 255);
          EXPECT_EQ(image.at(x, y), valid) << name << " at " << x << ", " << y;  // white stays white
          const Eigen::Vector2d p((x - rectified.cx) / rectified.fx, (y - rectified.cy) / rectified.fy);
          const Eigen::Vector2d source = project(camera, {p.x(), p.y(), 1});
          const bool beyond = (camera.lens == Lens::equidistant ? std::atan(p.norm()) : p.norm()) > limit;
          const bool outside = source.x() < -0.1 || source.y() < -0.1 || source.x() > camera.width - 0.9 ||
                               source.y() > camera.height - 0.9;
          const bool inside =
              source.x() > 0 && source.y() > 0 && source.x() < camera.width - 1 && source.y() < camera.height - 1;
          if (outside || beyond) {
            EXPECT_EQ(valid, 0) << name << " at " << x << ", " << y;
          } else if (inside) {
            EXPECT_EQ(valid, 255) << name << " at " << x << ", " << y;
          }
        }
    }
}

TEST(Undistort, IsTheSameOnEveryTarget) {
  for (const auto& [name, camera] : cameras()) {
    const Undistort undistort(camera, 0.3);
    const Image raw = noise(camera.width, camera.height, 3);
    Image first;
    undistort(raw, first);
    for (const std::int64_t target : simd_targets()) {
      const ForceTarget force(target);
      Image image;
      undistort(raw, image);
      EXPECT_TRUE(same(first, image)) << name << " on " << hwy::TargetName(target);
    }
  }
}

TEST(Undistort, WorksForTheSmallestImages) {
  for (const int width : {1, 2, 3, 17})
    for (const int height : {1, 2, 5}) {
      const Undistort undistort(
          Camera{width, height, 100, 100, (width - 1) / 2.0, (height - 1) / 2.0, Lens::radial_tangential, {1e-6}});
      const Image raw = noise(width, height, 4);
      Image image;
      undistort(raw, image);
      EXPECT_EQ(image.width(), width);
      EXPECT_EQ(image.height(), height);
    }
}

TEST(Undistort, UsesItsMemoryAgain) {
  const Camera camera = cameras()[0].camera;
  const Undistort undistort(camera);
  const Image raw = picture(camera.width, camera.height);
  Image image;
  undistort(raw, image);
  const std::uint8_t* const memory = image.row(0);
  undistort(raw, image);
  EXPECT_EQ(image.row(0), memory);
}

TEST(Undistort, NamesBothSizesWhenAnImageHasAnother) {
  const Undistort undistort(Camera{64, 48, 50, 50, 32, 24, Lens::rectified, {}});
  Image image;
  try {
    undistort(Image(64, 47), image);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("64x47"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("64x48"), std::string::npos);
  }
}

TEST(Undistort, RefusesCamerasThatCannotBe) {
  const Camera good{64, 48, 50, 50, 32, 24, Lens::radial_tangential, {}};
  const auto with = [&](auto set) {
    Camera camera = good;
    set(camera);
    return camera;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Undistort(with([](Camera& c) { c.width = 0; })), std::invalid_argument);
  EXPECT_THROW(Undistort(with([](Camera& c) { c.height = -1; })), std::invalid_argument);
  EXPECT_THROW(Undistort(with([](Camera& c) { c.width = 100000, c.height = 100000; })), std::invalid_argument);
  EXPECT_THROW(Undistort(with([](Camera& c) { c.fx = 0; })), std::invalid_argument);
  EXPECT_THROW(Undistort(with([&](Camera& c) { c.fy = nan; })), std::invalid_argument);
  EXPECT_THROW(Undistort(with([&](Camera& c) { c.cx = nan; })), std::invalid_argument);
  EXPECT_THROW(Undistort(with([&](Camera& c) { c.distortion[1] = nan; })), std::invalid_argument);
  EXPECT_THROW(Undistort(good, 1.1), std::invalid_argument);
  EXPECT_THROW(Undistort(good, nan), std::invalid_argument);
}

}  // namespace
}  // namespace pavo::test
