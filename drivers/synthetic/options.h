// What the synthetic street looks like, how it is driven through, and by what camera.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "types/camera.h"

namespace pavo {

/// The camera stands in front of frame `first` for `frames` frames: their poses are the one of frame first - 1, to the
/// bit.
struct Standstill {
  int first = 0;
  int frames = 0;
};

struct SyntheticOptions {
  std::uint64_t seed = 1;  ///< another seed is another street, with other people in it
  int frames = 300;        ///< 1 to 100 000
  double rate_hz = 10;     ///< of the camera
  double speed_mps = 8;    ///< of the camera along the street, 0 to 40; 0.8 m a frame at 10 Hz
  bool loop = false;       ///< true: the street is closed (some 440 m) and driven round for as many frames as asked
  double hills_m = 0;      ///< the street rises by so much within 90 m, falls, and rises again; 0 to 5; no loop does
  std::vector<Standstill> standstills;  ///< in rising order, apart from each other

  int width = 1226, height = 370;  ///< 16 to 8192
  double fx = 0;                   ///< focal length in pixels; 0: KITTI's, scaled to the width (707 at 1226)
  double camera_height_m = 1.65;   ///< above the road, 0.2 to 3
  double pitch_rad = 0;            ///< of the camera; positive looks up, +-0.5; a small wobble comes on top
  Lens lens = Lens::rectified;
  std::array<double, 8> distortion{};  ///< as in types/camera.h
  double noise_sigma = 1;              ///< of the sensor, gray levels, 0 to 50

  bool people = true;  ///< passers-by, along the street and across it
  double density = 1;  ///< of the passers-by, 0 to 5; 1 is about one in view per 10 m of street
  int companions = 0;  ///< people who walk along with the camera, 0 to 30 (also where `people` is off)

  int threads =
      0;  ///< that render one frame: 0: one per core, 1: only the caller's. The images are the same to the bit.
};

/// The truth about one person in one frame, pixels of the rendered (distorted, where the lens does) image.
/// A box runs from the left edge of its leftmost pixel to the right edge of its rightmost: x = left column - 0.5.
struct SyntheticPerson {
  int id = 0;  ///< the same over all frames
  bool companion = false;
  float x = 0, y = 0, width = 0,
        height = 0;  ///< tight box of the whole body as if nothing hid it; may reach beyond the image
  float visible_x = 0, visible_y = 0, visible_width = 0, visible_height = 0;  ///< of the pixels that show the person
  float visible_fraction = 0;  ///< pixels that show the person / pixels of the whole body, 0 to 1
  float depth_m = 0;           ///< along the optical axis
};

/// The camera that these options describe. Throws std::invalid_argument (one line, naming the option) on nonsense.
Camera synthetic_camera(const SyntheticOptions& options);

/// Throws std::invalid_argument (one line: option, value, what is allowed) where an option is out of its range.
void check(const SyntheticOptions& options);

}  // namespace pavo
