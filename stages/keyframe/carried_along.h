// Where in the picture something goes along with the camera: a car ahead, somebody who walks beside it.
//
// It keeps its place in the picture, so a place where points turned out not to stand still is no place for new ones for
// a while; without that, each keyframe begins some anew on the same car.
#pragma once

#include <algorithm>
#include <array>

#include "stages/pose/picture_cells.h"

namespace pavo {

/// Votes in the cells of a coarse grid; x and y are pixels. One caller at a time; allocates nothing.
class CarriedAlong {
 public:
  /// Over a picture of width x height px.
  CarriedAlong(int width, int height) : cells_{width, height} {}

  void forget() { votes_.fill(0); }
  /// The next frame.
  void fade() {
    for (float& v : votes_) v *= kFade;
  }
  /// A point at this pixel seemed to be below the ground.
  void add(float x, float y) { votes_[cells_.index_of(x, y)] += 1; }

  /// What is carried along stands on the ground, but may reach above the horizon, where a single point tells nothing:
  /// the cells up to two above one that is full count, too.
  bool holds(float x, float y) const {
    const int row = cells_.row(y), last = std::min(row + kUpwards, PictureCells::kRows - 1);
    for (int r = row; r <= last; ++r)
      if (votes_[PictureCells::index(r, cells_.column(x))] >= kEnough) return true;
    return false;
  }

 private:
  static constexpr int kUpwards = 2;
  static constexpr float kFade = 0.93f, kEnough = 1.5f;

  PictureCells cells_;
  std::array<float, PictureCells::kCount> votes_{};
};

}  // namespace pavo
