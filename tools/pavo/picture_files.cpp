#include "tools/pavo/picture_files.h"

#include <algorithm>
#include <stdexcept>

#include "drivers/sequences/directory.h"
#include "drivers/trajectories/append_file.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> pictures_of(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (is_image_name(entry->path().filename().string()) && !entry->is_directory()) files.push_back(entry->path());
  if (error) throw std::runtime_error(folder.string() + ": cannot be read: " + error.message());
  if (files.empty())
    throw std::runtime_error(folder.string() +
                             ": no picture in it: expected .png, .jpg, .pgm, .ppm, .bmp or .tif files");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<fs::path> picture_files(const std::vector<std::string>& paths) {
  std::vector<fs::path> files;
  for (const fs::path path : paths) {
    if (!fs::exists(path)) throw std::runtime_error(path.string() + ": no such file or folder");
    if (!fs::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    const fs::path within = path / "images";
    const bool elsewhere = fs::is_directory(within) && list_images(path).empty();
    const std::vector<fs::path> found = pictures_of(elsewhere ? within : path);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

void PictureReader::operator()(const fs::path& file, Image& image) {
  const std::string bytes = read_whole_file(file.string());
  encoded_.bytes.assign(bytes.begin(), bytes.end());
  try {
    decode_(encoded_, image, scratch_);
  } catch (const std::exception& e) {
    throw std::runtime_error(file.string() + ": " + e.what());
  }
}

}  // namespace pavo
