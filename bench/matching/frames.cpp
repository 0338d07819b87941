// The descriptors of two consecutive frames of a real drive, where PAVO_DATA names a folder with one.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "bench/matching/competitors.h"
#include "stages/decode/decode.h"
#include "stages/features/extract.h"

namespace pavo::bench {
namespace {

Features features_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EncodedImage encoded;
  encoded.bytes.assign(std::istreambuf_iterator<char>(file), {});
  Decode::Scratch decoder;
  Image image;
  Decode()(encoded, image, decoder);
  FeatureOptions options;
  options.max_features = 1500;
  ExtractFeatures::Scratch scratch;
  Features features;
  ExtractFeatures(options, image.width(), image.height())(image, features, scratch);
  return features;
}

}  // namespace

std::optional<Frames> real_frames() {
  const char* data = std::getenv("PAVO_DATA");
  if (!data) return std::nullopt;
  const auto folder = std::filesystem::path(data) / "sequences" / "kitti05-300" / "image_0";
  if (!std::filesystem::exists(folder / "000101.jpg")) return std::nullopt;
  return Frames{features_of(folder / "000100.jpg"), features_of(folder / "000101.jpg")};
}

}  // namespace pavo::bench
