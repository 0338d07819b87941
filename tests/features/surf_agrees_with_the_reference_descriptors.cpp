#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "bench/surf/reference.h"
#include "stages/decode/decode.h"
#include "stages/features/surf.h"
#include "tests/support/data.h"

namespace pavo::test {
namespace {

Image read_picture(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EncodedImage encoded;
  encoded.bytes.assign(std::istreambuf_iterator<char>(file), {});
  Decode::Scratch scratch;
  Image picture;
  Decode()(encoded, picture, scratch);
  return picture;
}

bench::Agreement agreement_of(int size, bool oriented) {
  const std::filesystem::path data = data_folder();
  const Image picture = read_picture(data / "sequences/kitti05-300/image_0/000100.jpg");
  const std::string name = std::string(oriented ? "oriented" : "upright") + "-size" + std::to_string(size) + ".txt";
  const bench::Reference reference = bench::read_reference(data / "surf" / name);
  EXPECT_EQ(reference.keypoints.size(), 300u);
  Features features;
  features.reserve(reference.keypoints.size());
  features.keypoints = reference.keypoints;
  Surf::Scratch scratch;
  Surf(size, oriented)(picture.view(), features, scratch);
  return bench::agreement(reference, features);
}

TEST(SurfAgreesWithTheReferenceDescriptors, Upright) {
  PAVO_NEEDS_DATA("surf/upright-size9.txt");
  for (int size : {9, 20}) {
    const bench::Agreement found = agreement_of(size, false);
    EXPECT_GT(found.cosines.front(), 0.9999) << size;
    EXPECT_GE(found.same_nearest, 0.97) << size;
  }
}

TEST(SurfAgreesWithTheReferenceDescriptors, Oriented) {
  PAVO_NEEDS_DATA("surf/oriented-size9.txt");
  for (int size : {9, 20}) {
    const bench::Agreement found = agreement_of(size, true);
    EXPECT_GT(found.cosines[found.cosines.size() / 20], 0.9999) << size;
    EXPECT_GE(found.same_nearest, 0.97) << size;
  }
}

}  // namespace
}  // namespace pavo::test
