// SURF-64 as the paper and OpenCV's documentation describe it, in double precision and one pixel at a time: what the
// fast one is compared with. It shares no line with it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "types/image.h"

namespace pavo::test {

class NaiveSurf {
 public:
  NaiveSurf(ImageView image, double keypoint_size)
      : image_(image), scale_(keypoint_size * 1.2 / 9), window_(static_cast<int>(21 * scale_ + 1e-5)) {}

  std::array<double, 64> upright(double x, double y) const {
    // The window's first axis runs up, its second one to the right; its middle falls between pixels if its side is
    // even.
    const double half = 0.5 * (window_ - 1);
    const double left = std::nearbyint(x - half), bottom = std::nearbyint(y + half);
    return describe([&](int i, int j) { return clamped(static_cast<int>(left) + i, static_cast<int>(bottom) - j); });
  }

  std::array<double, 64> oriented(double x, double y, double angle) const {
    const double c = std::cos(angle), s = std::sin(angle), half = 0.5 * (window_ - 1);
    return describe([&](int i, int j) {
      const double along = j - half, across = i - half;
      return bilinear(x + along * c - across * s, y + along * s + across * c);
    });
  }

  /// The dominant gradient's direction, from x towards y.
  double angle(double x, double y) const {
    struct Gradient {
      double x, y, degrees;
    };
    std::vector<Gradient> gradients;
    const int wavelet = 2 * static_cast<int>(std::nearbyint(2 * scale_)), half = wavelet / 2;
    for (int i = -6; i <= 6; ++i) {
      for (int j = -6; j <= 6; ++j) {
        if (i * i + j * j > 36) continue;
        const int left = static_cast<int>(std::lrint(static_cast<float>(x + i * scale_ - 0.5 * (wavelet - 1))));
        const int top = static_cast<int>(std::lrint(static_cast<float>(y + j * scale_ - 0.5 * (wavelet - 1))));
        if (left < 0 || top < 0 || left + wavelet > image_.width || top + wavelet > image_.height) continue;
        const double weight = std::exp(-(i * i + j * j) / (2 * 2.5 * 2.5));
        const double gx = weight * (box(left + half, top, half, wavelet) - box(left, top, half, wavelet));
        const double gy = weight * (box(left, top + half, wavelet, half) - box(left, top, wavelet, half));
        const double degrees = std::atan2(gy, gx) * 180 / std::numbers::pi;
        gradients.push_back({gx, gy, std::nearbyint(degrees < 0 ? degrees + 360 : degrees)});
      }
    }
    double longest = 0, angle = 0;
    for (int center = 0; center < 360; center += 5) {
      double sum_x = 0, sum_y = 0;
      for (const Gradient& g : gradients) {
        const double apart = std::abs(g.degrees - center);
        if (apart >= 30 && apart <= 330) continue;
        sum_x += g.x;
        sum_y += g.y;
      }
      if (sum_x * sum_x + sum_y * sum_y > longest) {
        longest = sum_x * sum_x + sum_y * sum_y;
        angle = std::atan2(sum_y, sum_x);
      }
    }
    return angle;
  }

 private:
  int clamped(int x, int y) const {
    return image_.at(std::clamp(x, 0, image_.width - 1), std::clamp(y, 0, image_.height - 1));
  }

  double bilinear(double x, double y) const {
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    const double a = x - x0, b = y - y0;
    return std::nearbyint((clamped(x0, y0) * (1 - a) + clamped(x0 + 1, y0) * a) * (1 - b) +
                          (clamped(x0, y0 + 1) * (1 - a) + clamped(x0 + 1, y0 + 1) * a) * b);
  }

  double box(int x0, int y0, int width, int height) const {
    double sum = 0;
    for (int y = y0; y < y0 + height; ++y) {
      for (int x = x0; x < x0 + width; ++x) sum += image_.at(x, y);
    }
    return sum;
  }

  /// The share of pixel k in sample i.
  double overlap(int i, int k) const {
    const double size = window_ / 21.0;
    return std::max(0.0, std::min((i + 1) * size, k + 1.0) - std::max(i * size, 1.0 * k)) / size;
  }

  template <class Pixel>
  std::array<double, 64> describe(const Pixel& pixel) const {
    double grid[21][21];
    for (int i = 0; i < 21; ++i) {
      for (int j = 0; j < 21; ++j) {
        double sum = 0;
        for (int k = 0; k < window_; ++k) {
          if (overlap(i, k) < 1e-9) continue;
          for (int l = 0; l < window_; ++l) {
            if (overlap(j, l) > 1e-9) sum += overlap(i, k) * overlap(j, l) * pixel(k, l);
          }
        }
        grid[i][j] = std::nearbyint(sum);
      }
    }
    std::array<double, 64> d{};
    double squares = 0;
    for (int i = 0; i < 20; ++i) {
      for (int j = 0; j < 20; ++j) {
        const double weight = std::exp(-((i - 9.5) * (i - 9.5) + (j - 9.5) * (j - 9.5)) / (2 * 3.3 * 3.3));
        const double along = weight * (grid[i][j + 1] - grid[i][j] + grid[i + 1][j + 1] - grid[i + 1][j]);
        const double across = weight * (grid[i + 1][j] - grid[i][j] + grid[i + 1][j + 1] - grid[i][j + 1]);
        double* cell = d.data() + 4 * (i / 5 * 4 + j / 5);
        cell[0] += along;
        cell[1] += across;
        cell[2] += std::abs(along);
        cell[3] += std::abs(across);
      }
    }
    for (double value : d) squares += value * value;
    for (double& value : d) value = squares > 0 ? value / std::sqrt(squares) : 0;
    return d;
  }

  ImageView image_;
  double scale_;
  int window_;
};

}  // namespace pavo::test
