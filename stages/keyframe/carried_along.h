// Where in the picture something goes along with the camera: a car ahead, somebody who walks beside it.
//
// It keeps its place in the picture, so a place where points turned out not to stand still is no place for new ones for
// a while; without that, each keyframe begins some anew on the same car.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace pavo {

/// Votes in a coarse grid of cells over the picture. One caller at a time; allocates nothing.
class CarriedAlong {
 public:
  CarriedAlong(int width, int height) : width_(width), height_(height) {}

  void forget() { votes_.fill(0); }
  /// The next frame.
  void fade() {
    for (float& v : votes_) v *= kFade;
  }
  /// A point at this pixel seemed to be below the ground.
  void add(float x, float y) { votes_[cell(row(y), column(x))] += 1; }

  /// What is carried along stands on the ground, but may reach above the horizon, where a single point tells nothing:
  /// the cells up to two above one that is full count, too.
  bool holds(float x, float y) const {
    const int last = std::min(row(y) + kUpwards, kRows - 1);
    for (int r = row(y); r <= last; ++r)
      if (votes_[cell(r, column(x))] >= kEnough) return true;
    return false;
  }

 private:
  static constexpr int kColumns = 16, kRows = 8, kUpwards = 2;
  static constexpr float kFade = 0.93f, kEnough = 1.5f;

  static int place(float at, int size, int cells) {
    return std::clamp(static_cast<int>(at * static_cast<float>(cells) / static_cast<float>(size)), 0, cells - 1);
  }
  static std::size_t cell(int row, int column) {
    const int place = row * kColumns + column;
    return static_cast<std::size_t>(place);
  }
  int column(float x) const { return place(x, width_, kColumns); }
  int row(float y) const { return place(y, height_, kRows); }

  int width_, height_;
  std::array<float, kColumns * kRows> votes_{};
};

}  // namespace pavo
