// Chessboards in front of a camera that is known to the last digit: their corners, and pictures of them.
#pragma once

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "stages/calibration/board.h"
#include "types/camera.h"
#include "types/image.h"
#include "types/lens.h"
#include "types/pose.h"

namespace pavo::test {

inline constexpr Board kBoard{.columns = 8, .rows = 6, .square_m = 0.03};

inline Camera pinhole() {
  return {.width = 480,
          .height = 360,
          .fx = 310.5,
          .fy = 312.25,
          .cx = 236.75,
          .cy = 184.5,
          .lens = Lens::radial_tangential,
          .distortion = {-0.31, 0.12, 0.0006, -0.0004, -0.02}};
}

inline Camera fisheye() {
  return {.width = 480,
          .height = 360,
          .fx = 190.5,
          .fy = 191.25,
          .cx = 236.75,
          .cy = 184.5,
          .lens = Lens::equidistant,
          .distortion = {-0.02, 0.006, -0.003, 0.0004}};
}

/// T_c_b of boards all over the image, tilted to all sides, near enough to be large.
inline std::vector<SE3> poses(const Camera& camera, int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  const Eigen::Vector3d middle(0.5 * (kBoard.columns - 1) * kBoard.square_m, 0.5 * (kBoard.rows - 1) * kBoard.square_m,
                               0);
  const double border = camera.lens == Lens::equidistant ? 40 : 20;  // for the squares around the inner corners
  std::vector<SE3> poses;
  while (static_cast<int>(poses.size()) < count) {
    const auto ray = unproject(camera, {uniform(0, camera.width), uniform(0, camera.height)});
    if (!ray) continue;
    const Eigen::Matrix3d facing =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), *ray).toRotationMatrix();
    SE3 T;
    T.R = facing * (Eigen::AngleAxisd(uniform(-0.6, 0.6), Eigen::Vector3d::UnitX()) *
                    Eigen::AngleAxisd(uniform(-0.6, 0.6), Eigen::Vector3d::UnitY()) *
                    Eigen::AngleAxisd(uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ()))
                       .toRotationMatrix();
    T.t = uniform(0.3, 0.5) * *ray - T.R * middle;
    bool inside = true;
    for (int i = 0; i < kBoard.corners(); ++i) {
      const Eigen::Vector2d p = project(camera, T * kBoard.point(i));
      inside =
          inside && p.x() > border && p.y() > border && p.x() < camera.width - border && p.y() < camera.height - border;
    }
    if (inside) poses.push_back(T);
  }
  return poses;
}

/// Where the corners are, each off by Gaussian noise of `sigma_px` in both directions.
inline BoardCorners corners_seen(const Camera& camera, const SE3& T_c_b, double sigma_px, std::mt19937& random) {
  std::normal_distribution<double> noise(0, 1);
  BoardCorners corners;
  for (int i = 0; i < kBoard.corners(); ++i) {
    corners.push_back(project(camera, T_c_b * kBoard.point(i)));
    if (sigma_px > 0) corners.back() += sigma_px * Eigen::Vector2d(noise(random), noise(random));
  }
  return corners;
}

/// The board on gray, every pixel the mean over 5 x 5 points of it, with the sensor's noise.
class BoardPainter {
 public:
  explicit BoardPainter(const Camera& camera) : camera_(camera) {
    for (int y = -1; y <= camera.height; ++y)
      for (int x = -1; x <= camera.width; ++x)
        rays_.push_back(unproject(camera, {x, y}).value_or(Eigen::Vector3d::Zero()));
    for (int y = 0; y <= camera.height; ++y)
      for (int x = 0; x <= camera.width; ++x)
        corner_rays_.push_back(unproject(camera, {x - 0.5, y - 0.5}).value_or(Eigen::Vector3d::Zero()));
  }

  void paint(const SE3& T_c_b, double noise_sigma, std::mt19937& random, Image& image) const {
    std::normal_distribution<double> noise(0, noise_sigma);
    image.resize(camera_.width, camera_.height);
    const SE3 T_b_c = T_c_b.inverse();
    std::vector<double> corners;
    corners.reserve(corner_rays_.size());
    for (const Eigen::Vector3d& r : corner_rays_) corners.push_back(brightness(T_b_c, r));
    for (int y = 0; y < camera_.height; ++y)
      for (int x = 0; x < camera_.width; ++x) {
        const double* above = &corners[static_cast<std::size_t>(y * (camera_.width + 1) + x)];
        const double* below = above + camera_.width + 1;
        const bool even = above[0] == above[1] && above[0] == below[0] && above[0] == below[1];
        const double mean = even ? above[0] : mean_brightness(T_b_c, x, y);
        image.at(x, y) = static_cast<std::uint8_t>(std::clamp(mean + noise(random), 0.0, 255.0) + 0.5);
      }
  }

 private:
  const Eigen::Vector3d& ray(int x, int y) const {
    return rays_[static_cast<std::size_t>((y + 1) * (camera_.width + 2) + x + 1)];
  }

  double mean_brightness(const SE3& T_b_c, int x, int y) const {
    constexpr int kSide = 5;
    double sum = 0;
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const double dx = (i + 0.5) / kSide - 0.5, dy = (j + 0.5) / kSide - 0.5;
        const int sx = dx < 0 ? -1 : 1, sy = dy < 0 ? -1 : 1;  // rays in between are linear to within 1e-5 pixels
        const Eigen::Vector3d r =
            ray(x, y) + std::abs(dx) * (ray(x + sx, y) - ray(x, y)) + std::abs(dy) * (ray(x, y + sy) - ray(x, y));
        sum += brightness(T_b_c, r);
      }
    return sum / (kSide * kSide);
  }

  // Of what a ray of the camera meets in the board's plane.
  static double brightness(const SE3& T_b_c, const Eigen::Vector3d& ray) {
    constexpr double kBlack = 40, kWhite = 220, kAround = 130;
    const Eigen::Vector3d direction = T_b_c.R * ray;
    const double distance = -T_b_c.t.z() / direction.z();
    if (!(distance > 0)) return kAround;
    const Eigen::Vector3d p = (T_b_c.t + distance * direction) / kBoard.square_m;
    const int column = static_cast<int>(std::floor(p.x())) + 1, row = static_cast<int>(std::floor(p.y())) + 1;
    if (column < -1 || row < -1 || column > kBoard.columns + 1 || row > kBoard.rows + 1) return kAround;
    if (column < 0 || row < 0 || column > kBoard.columns || row > kBoard.rows) return kWhite;  // the margin
    return (column + row) % 2 ? kWhite : kBlack;
  }

  Camera camera_;
  std::vector<Eigen::Vector3d> rays_;         ///< of the pixels' centres, and of one pixel more around them
  std::vector<Eigen::Vector3d> corner_rays_;  ///< of their corners: where all four show the same, so does the pixel
};

}  // namespace pavo::test
