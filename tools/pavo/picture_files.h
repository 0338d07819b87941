// Single pictures, by the names that a command line gives.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "stages/decode/decode.h"
#include "types/image.h"

namespace pavo {

/// The files that are named, and the pictures (by their extension) of the folders that are named: those in its
/// `images/`, where a folder has none itself; in order of their names. Throws std::runtime_error naming a path that is
/// not there, or a folder without a picture.
std::vector<std::filesystem::path> picture_files(const std::vector<std::string>& paths);

/// Reads and decodes; one per thread.
class PictureReader {
 public:
  /// 8-bit gray, whatever the file has. Throws std::runtime_error with one line that names the file.
  void operator()(const std::filesystem::path& file, Image& image);

 private:
  Decode decode_;
  Decode::Scratch scratch_;
  EncodedImage encoded_;
};

}  // namespace pavo
