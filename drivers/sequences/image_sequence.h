// A sequence whose frames are image files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/sequences/sequence.h"

namespace pavo {

/// One frame of a recording: where its bytes are, and when it was taken.
struct FrameFile {
  std::string path;
  std::string name;
  std::int64_t t_ns = 0;
};

/// A recording as its layout's opener puts it together.
struct Recording {
  SequenceInfo info;
  std::vector<FrameFile> frames;
};

/// Reads the files one after the other, and lets the kernel fetch a few ahead. After the largest frame has been seen,
/// read() allocates nothing.
class ImageSequence final : public Sequence {
 public:
  explicit ImageSequence(Recording recording);

  const SequenceInfo& info() const override { return recording_.info; }
  std::optional<FrameStamp> peek() override;
  bool read(EncodedImage& image, FrameStamp& stamp) override;
  bool skip() override;

 private:
  bool at_end() const { return next_ == recording_.frames.size(); }
  void stamp_next(FrameStamp& stamp) const;

  Recording recording_;
  std::size_t next_ = 0;
};

/// The bytes of a regular file into `bytes`, which keeps its capacity. Throws FrameError (one line, with the path)
/// where it cannot be read or is empty.
void read_image_file(const std::string& path, std::vector<std::uint8_t>& bytes);

}  // namespace pavo
