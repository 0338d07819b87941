// The synthetic street, small and in memory, as frames to push and as a source.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <vector>

#include "drivers/synthetic/synthetic_street.h"
#include "engine/pipeline.h"
#include "pavo/frame.h"

namespace pavo::test {

struct Street {
  Camera camera;
  std::vector<EncodedImage> frames;
  std::vector<std::int64_t> t_ns;
  std::vector<SE3> truth;
};

inline Street rendered_street(int height) {
  SyntheticOptions options;
  options.frames = 30;
  options.width = 320;
  options.height = height;
  SyntheticStreet source(options);
  Street s{.camera = *source.info().camera, .truth = source.info().groundtruth->T_w_c};
  EncodedImage image;
  for (FrameStamp stamp; source.read(image, stamp);) {
    s.frames.push_back(image);
    s.t_ns.push_back(stamp.t_capture_ns);
  }
  return s;
}

/// 30 frames of 320x96, rendered once a process.
inline const Street& street() {
  static const Street rendered = rendered_street(96);
  return rendered;
}

/// The same, high enough for people to be looked for.
inline const Street& high_street() {
  static const Street rendered = rendered_street(176);
  return rendered;
}

/// Forth and back along the street, as often as is asked; no step is larger than one frame's.
inline std::size_t forth_and_back(std::size_t n) {
  const std::size_t period = 2 * (street().frames.size() - 1), at = n % period;
  return at < street().frames.size() ? at : period - at;
}

/// `count` frames; `before(n)` is called before each is read.
class StreetSource : public Source<Frame> {
 public:
  explicit StreetSource(std::size_t count, std::function<void(std::size_t)> before = {}, const Street& where = street())
      : count_(count), before_(std::move(before)), where_(where) {}

  bool read(FrameInfo& info, Frame& frame) override {
    if (next_ == count_) return false;
    if (before_) before_(next_);
    info.source_index = static_cast<std::int64_t>(next_);
    info.t_capture_ns = 100'000'000 * info.source_index;
    const EncodedImage& image = where_.frames[forth_and_back(next_++)];
    frame.encoded.encoding = image.encoding;
    frame.encoded.width = image.width;
    frame.encoded.height = image.height;
    frame.encoded.stride = image.stride;
    frame.encoded.bytes = image.bytes;
    return true;
  }
  std::optional<std::int64_t> next_arrival_ns() override {
    return next_ == count_ ? std::nullopt : std::optional<std::int64_t>(0);
  }

 private:
  std::size_t count_, next_ = 0;
  std::function<void(std::size_t)> before_;
  const Street& where_;
};

}  // namespace pavo::test
