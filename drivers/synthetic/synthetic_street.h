// A street that never was, as a sequence: the embedded demo, and the tests' world, with exact ground truth.
#pragma once

#include <memory>
#include <vector>

#include "drivers/sequences/sequence.h"
#include "drivers/synthetic/options.h"

namespace pavo {

/// Frames of gray8, rendered when they are read. Everything is a pure function of the options: the same bytes on every
/// run, for any number of threads, whatever was read or skipped before.
///
/// The constructor paints the street (about a second at 1226 x 370, in proportion to the image's size); read() renders
/// (no files); skip() costs nothing. Memory is used again from frame to frame, but a frame with more people or
/// houses than ever before may allocate. One thread at a time may call it.
class SyntheticStreet final : public Sequence {
 public:
  /// Throws std::invalid_argument (one line: option, value, what is allowed).
  explicit SyntheticStreet(const SyntheticOptions& options);
  ~SyntheticStreet() override;

  const SequenceInfo& info() const override;
  std::optional<FrameStamp> peek() override;
  bool read(EncodedImage& image, FrameStamp& stamp) override;
  bool skip() override;

  const SyntheticOptions& options() const;
  /// Who can be seen in a frame (0 to frames - 1), nearest first; does not touch the position of read().
  /// Throws std::out_of_range.
  std::vector<SyntheticPerson> people(int frame) const;
  /// Where the camera stands in the world of the trajectory (its first pose): the road is the plane { p : n . p = h }
  /// with n its unit normal, down, and h the camera's height above it in frame 0, in metres. With hills: there only.
  Eigen::Vector3d road_normal() const;
  double road_height() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pavo
