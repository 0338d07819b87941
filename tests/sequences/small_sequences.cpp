#include "tests/sequences/small_sequences.h"

#include <cstdio>

namespace pavo::test {

std::string pgm(int width, int height, char shade) {
  return "P5\n# made by a test\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n" +
         std::string(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), shade);
}

std::string frame_name(int number, const char* extension) {
  char name[16];
  std::snprintf(name, sizeof name, "%06d", number % 1000000);
  return std::string(name) + extension;
}

void write_kitti(const TemporaryFolder& folder, int frames) {
  std::string times, poses;
  for (int i = 0; i < frames; ++i) {
    folder.write("image_0/" + frame_name(i), pgm(64, 48, static_cast<char>(i)));
    times += std::to_string(i) + "e-01\n";
    poses += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(i) + "\n";
  }
  folder.write("times.txt", times);
  folder.write("poses.txt", poses);
  folder.write("calib.txt", kKittiCalibration);
}

std::vector<ReadFrame> read_all(Sequence& sequence) {
  std::vector<ReadFrame> frames;
  EncodedImage image;
  for (bool more = true; more;) {
    ReadFrame frame;
    try {
      more = sequence.read(image, frame.stamp);
      frame.bytes.assign(image.bytes.begin(), image.bytes.end());
    } catch (const FrameError& error) {
      frame.error = error.what();
    }
    if (more) frames.push_back(frame);
  }
  return frames;
}

std::string open_error(const std::string& source, const SequenceOptions& options) {
  return error_of([&] { open_sequence(source, options); });
}

}  // namespace pavo::test
