#include "drivers/sequences/directory.h"

#include <algorithm>
#include <array>
#include <system_error>

#include "drivers/calibration/text.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

/// Takes the number that `text` begins with, without leading zeros.
std::string_view take_number(std::string_view& text) {
  while (!text.empty() && text.front() == '0') text.remove_prefix(1);
  const std::string_view digits =
      text.substr(0, static_cast<std::size_t>(std::ranges::find_if_not(text, is_digit) - text.begin()));
  text.remove_prefix(digits.size());
  return digits;
}

template <typename Visit>
void visit_folder(const fs::path& folder, Visit visit) {
  std::error_code error;
  fs::directory_iterator entries(folder, error);
  for (; !error && entries != fs::directory_iterator{}; entries.increment(error)) {
    if (!visit(*entries)) return;
  }
  if (error) fail_at(folder.string(), 0, "cannot be listed (" + error.message() + "): give a folder that can be read");
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  std::string_view left = a, right = b;
  while (!left.empty() && !right.empty()) {
    if (is_digit(left.front()) && is_digit(right.front())) {
      const std::string_view m = take_number(left), n = take_number(right);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else {
      if (left.front() != right.front()) return left.front() < right.front();
      left.remove_prefix(1);
      right.remove_prefix(1);
    }
  }
  if (left.empty() != right.empty()) return left.empty();
  return a < b;  // the same but for leading zeros
}

bool is_image_name(std::string_view name) {
  constexpr std::array<std::string_view, 8> kExtensions = {".png", ".jpg", ".jpeg", ".pgm",
                                                           ".ppm", ".bmp", ".tif",  ".tiff"};
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || dot == 0 || name.front() == '.') return false;
  std::string extension(name.substr(dot));
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::ranges::find(kExtensions, extension) != kExtensions.end();
}

std::vector<std::string> list_images(const fs::path& folder) {
  std::vector<std::string> names;
  visit_folder(folder, [&](const fs::directory_entry& entry) {
    std::string name = entry.path().filename().string();
    if (is_image_name(name)) names.push_back(std::move(name));
    return true;
  });
  std::ranges::sort(names, natural_less);
  return names;
}

bool is_empty_folder(const fs::path& folder) {
  bool empty = true;
  visit_folder(folder, [&](const fs::directory_entry&) { return empty = false; });
  return empty;
}

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error) && !fs::is_directory(path, error);
}

}  // namespace pavo
