#include <gmock/gmock.h>

#include <limits>
#include <stdexcept>

#include "tests/synthetic/support.h"

namespace pavo {
namespace {

using test::small_street;
using testing::HasSubstr;

TEST(SyntheticSequence, TellsWhatItIs) {
  const SyntheticStreet street(small_street(5));
  const SequenceInfo& info = street.info();
  EXPECT_EQ(info.layout, "synthetic");
  EXPECT_EQ(info.calibration_source, "synthetic");
  ASSERT_TRUE(info.camera.has_value());
  EXPECT_EQ(info.camera->width, 320);
  EXPECT_EQ(info.camera->height, 96);
  EXPECT_EQ(info.camera->lens, Lens::rectified);
  EXPECT_NEAR(info.camera->fx, 707.0912 * 320 / 1226, 1e-9);
  EXPECT_TRUE(info.has_times);
  EXPECT_EQ(info.frame_count, 5);
}

TEST(SyntheticSequence, PeeksReadsSkipsAndEnds) {
  SyntheticStreet street(small_street(3));
  EncodedImage image;
  FrameStamp stamp;
  ASSERT_TRUE(street.peek());
  EXPECT_EQ(street.peek()->index, 0);
  ASSERT_TRUE(street.read(image, stamp));
  EXPECT_EQ(stamp.index, 0);
  EXPECT_EQ(stamp.t_capture_ns, 0);
  EXPECT_EQ(image.encoding, Encoding::gray8);
  EXPECT_EQ(image.bytes.size(), 320U * 96);
  EXPECT_EQ(image.stride, 320);
  EXPECT_TRUE(street.skip());
  ASSERT_TRUE(street.read(image, stamp));
  EXPECT_EQ(stamp.index, 2);
  EXPECT_EQ(stamp.t_capture_ns, 200'000'000);
  EXPECT_EQ(stamp.name, "000002.png");
  EXPECT_FALSE(street.peek());
  EXPECT_FALSE(street.read(image, stamp));
  EXPECT_FALSE(street.skip());
}

TEST(SyntheticSequence, TakesOddSizesAndSmallOnes) {
  SyntheticOptions options = small_street(2);
  for (const auto& [width, height] : {std::pair{16, 16}, {97, 33}, {33, 97}}) {
    options.width = width;
    options.height = height;
    for (const test::Gray& frame : test::render(options))
      EXPECT_EQ(frame.pixels.size(), static_cast<std::size_t>(width * height));
  }
}

TEST(SyntheticSequence, IsExposedLikeAPhotograph) {
  double sum = 0, squares = 0;
  const auto frames = test::render(small_street(6));
  int n = 0, black = 0, white = 0;
  for (const test::Gray& frame : frames) {
    for (const int v : frame.pixels) {
      sum += v;
      squares += static_cast<double>(v) * v;
      black += v < 3;
      white += v > 252;
      ++n;
    }
  }
  EXPECT_GT(sum / n, 70);
  EXPECT_LT(sum / n, 150);
  EXPECT_GT(std::sqrt(squares / n - sum / n * sum / n), 28);
  EXPECT_LT(black, n / 50);
  EXPECT_LT(white, n / 20);
}

/// The message of what the constructor throws.
std::string complaint(const SyntheticOptions& options) {
  try {
    const SyntheticStreet street(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(SyntheticOptionsCheck, NamesWhatIsWrong) {
  const auto with = [](auto change) {
    SyntheticOptions options = small_street(2);
    change(options);
    const std::string text = complaint(options);
    EXPECT_EQ(text.find('\n'), std::string::npos);
    return text;
  };
  EXPECT_THAT(with([](auto& o) { o.frames = 0; }), HasSubstr("frames is 0, expected 1 to"));
  EXPECT_THAT(with([](auto& o) { o.width = 3; }), HasSubstr("width"));
  EXPECT_THAT(with([](auto& o) { o.height = 100000; }), HasSubstr("height"));
  EXPECT_THAT(with([](auto& o) { o.rate_hz = 0; }), HasSubstr("rate_hz"));
  EXPECT_THAT(with([](auto& o) { o.speed_mps = -1; }), HasSubstr("speed_mps"));
  EXPECT_THAT(with([](auto& o) { o.fx = std::numeric_limits<double>::quiet_NaN(); }), HasSubstr("fx"));
  EXPECT_THAT(with([](auto& o) { o.noise_sigma = -1; }), HasSubstr("noise_sigma"));
  EXPECT_THAT(with([](auto& o) { o.pitch_rad = 2; }), HasSubstr("pitch_rad"));
  EXPECT_THAT(with([](auto& o) { o.camera_height_m = 0; }), HasSubstr("camera_height_m"));
  EXPECT_THAT(with([](auto& o) { o.density = 99; }), HasSubstr("density"));
  EXPECT_THAT(with([](auto& o) { o.hills_m = 6; }), HasSubstr("hills_m"));
  EXPECT_THAT(with([](auto& o) { o.hills_m = 1, o.loop = true; }), HasSubstr("hills_m"));
  EXPECT_THAT(with([](auto& o) { o.companions = -1; }), HasSubstr("companions"));
  EXPECT_THAT(with([](auto& o) { o.threads = -1; }), HasSubstr("threads"));
  EXPECT_THAT(with([](auto& o) { o.distortion[2] = std::numeric_limits<double>::infinity(); }),
              HasSubstr("distortion[2]"));
  EXPECT_THAT(with([](auto& o) { o.standstills = {{0, 3}}; }), HasSubstr("standstill"));
  EXPECT_THAT(with([](auto& o) { o.standstills = {{5, 3}, {7, 1}}; }), HasSubstr("standstill"));
}

}  // namespace
}  // namespace pavo
