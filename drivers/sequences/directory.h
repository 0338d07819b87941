// What is in a folder.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pavo {

/// '0' to '9', whatever the locale.
constexpr bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Numbers inside names count as numbers: "frame9" < "frame10". A total order.
bool natural_less(std::string_view a, std::string_view b);

/// Does the name end as image files do (.png, .jpg, .jpeg, .pgm, .ppm, .bmp, .tif, .tiff, in any case)? Hidden
/// files are none.
bool is_image_name(std::string_view name);

/// The names of the image files in `folder`, in natural order. Throws std::runtime_error (one line) where the folder
/// cannot be read.
std::vector<std::string> list_images(const std::filesystem::path& folder);

/// Is there anything in it? Throws as list_images().
bool is_empty_folder(const std::filesystem::path& folder);

/// These never throw: what cannot be looked at is not there.
bool is_folder(const std::filesystem::path& path);
bool is_file(const std::filesystem::path& path);

}  // namespace pavo
