// Small recordings in temporary folders.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/sequences/sequence.h"
#include "tests/calibration/error_of.h"
#include "tests/support/temporary.h"

namespace pavo::test {

/// A gray PGM image; its pixels have the value `shade`.
std::string pgm(int width, int height, char shade);

/// A KITTI odometry sequence of `frames` images of 64x48 in image_0, 0.1 s apart, driving along z by 1 m a frame.
void write_kitti(const TemporaryFolder& folder, int frames);
inline constexpr const char* kKittiCalibration = "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP2: 60 0 32 6 0 60 24 0 0 0 1 0\n";

/// "000007.pgm"
std::string frame_name(int number, const char* extension = ".pgm");

/// All frames, with their stamps: "" for those that throw FrameError.
struct ReadFrame {
  FrameStamp stamp;
  std::string bytes;
  std::string error;
};
std::vector<ReadFrame> read_all(Sequence& sequence);

/// The message with which `source` cannot be opened.
std::string open_error(const std::string& source, const SequenceOptions& options = {});

}  // namespace pavo::test
