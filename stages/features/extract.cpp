#include "stages/features/extract.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace pavo {
namespace {

void expect(bool good, const char* option, double value, const char* expected) {
  if (good) return;
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  throw std::runtime_error("features: " + std::string(option) + " = " + text + ": expected " + expected);
}

const FeatureOptions& checked(const FeatureOptions& options) {
  expect(options.max_features >= 1 && options.max_features <= 65535, "max_features", options.max_features,
         "1 to 65535");
  expect(options.cell_px >= 8 && options.cell_px <= 255, "cell_px", options.cell_px, "8 to 255");
  expect(options.min_score >= 1 && options.min_score <= 254, "min_score", options.min_score, "1 to 254");
  expect(options.keypoint_size >= Surf::kSmallestSize && options.keypoint_size <= Surf::kLargestSize, "keypoint_size",
         options.keypoint_size, "9 to 21");
  return options;
}

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

/// How many of the pixels left of and above (x, y) have no source, at y * (width + 1) + x.
std::vector<int> count_masked(ImageView mask) {
  const int pitch = mask.width + 1;
  std::vector<int> sums(static_cast<std::size_t>(pitch) * (static_cast<std::size_t>(mask.height) + 1));
  for (int y = 0; y < mask.height; ++y) {
    int masked = 0;
    for (int x = 0; x < mask.width; ++x) {
      masked += mask.at(x, y) == 0;
      sums[(y + 1) * pitch + x + 1] = sums[y * pitch + x + 1] + masked;
    }
  }
  return sums;
}

/// The pixels whose square of 2 margin + 1 pixels lies within the image and touches nothing masked.
std::vector<std::uint8_t> allowed_pixels(int width, int height, ImageView mask, int margin) {
  std::vector<std::uint8_t> allowed(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const std::vector<int> masked = mask.empty() ? std::vector<int>() : count_masked(mask);
  const int pitch = width + 1;
  for (int y = margin; y < height - margin; ++y) {
    for (int x = margin; x < width - margin; ++x) {
      bool free = true;
      if (!masked.empty()) {
        const int* top = &masked[(y - margin) * pitch];
        const int* bottom = &masked[(y + margin + 1) * pitch];
        free = bottom[x + margin + 1] - bottom[x - margin] - top[x + margin + 1] + top[x - margin] == 0;
      }
      allowed[y * width + x] = free;
    }
  }
  return allowed;
}

}  // namespace

ExtractFeatures::ExtractFeatures(const FeatureOptions& options, int width, int height, ImageView mask)
    : options_(checked(options)),
      width_(width),
      height_(height),
      surf_(options.keypoint_size, options.oriented),
      margin_(options.descriptors ? std::max(kFastRadius, surf_.support()) : kFastRadius),
      grid_(width, height, options.cell_px, options.max_features) {
  if (!mask.empty() && (mask.width != width || mask.height != height)) {
    throw std::runtime_error("features: the mask is " + size_text(mask.width, mask.height) + ": expected the images' " +
                             size_text(width, height));
  }
  allowed_ = allowed_pixels(width, height, mask, margin_);
}

void ExtractFeatures::operator()(const Image& image, Features& features, Scratch& scratch) const {
  if (image.width() != width_ || image.height() != height_) {
    throw std::runtime_error("features: the image is " + size_text(image.width(), image.height()) + ": expected " +
                             size_text(width_, height_) + " as all of this run");
  }
  features.reserve(static_cast<std::size_t>(options_.max_features));
  features.keypoints.clear();
  std::span<Corner> corners = detect_fast(image.view(), options_.min_score, scratch.fast);
  const auto excluded = [&](const Corner& corner) { return allowed_[corner.y * width_ + corner.x] == 0; };
  corners = {corners.begin(), std::remove_if(corners.begin(), corners.end(), excluded)};
  for (const Corner& corner : grid_.keep_best(corners, scratch.grid)) {
    features.keypoints.push_back(
        {static_cast<float>(corner.x), static_cast<float>(corner.y), static_cast<float>(corner.score), 0});
  }
  if (options_.descriptors) surf_(image.view(), features, scratch.surf);
}

}  // namespace pavo
