// From the driver's buffers to the camera's parameters: somebody moves a board before a camera and holds it still here
// and there, the cable is pulled out in between, and what `pavo calibrate /dev/videoN` takes is right.
#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "stages/calibration/bundle.h"
#include "stages/calibration/calibrate_camera.h"
#include "tests/board_calibration/boards.h"
#include "tests/v4l2/support.h"
#include "tools/pavo/watch_board.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using v4l2::test::PlayedDriver;

constexpr std::int64_t kPeriod_ns = 100'000'000;

/// Shows one picture after the other, each when the one before was taken, as a camera of 10 Hz does.
class Film {
 public:
  Film(PlayedDriver& driver, const Camera& camera, std::uint32_t fourcc)
      : driver_(driver), painter_(camera), yuyv_(fourcc == V4L2_PIX_FMT_YUYV) {}

  void end() { ended_ = true; }

  void show(const SE3& T_c_b, int frames) {
    painter_.paint(T_c_b, 2, random_, image_);
    bytes_.clear();
    for (int y = 0; y < image_.height(); ++y)
      for (int x = 0; x < image_.width(); ++x) {
        bytes_.push_back(image_.at(x, y));
        if (yuyv_) bytes_.push_back(x % 2 ? 100 : 150);  // colours are not looked at
      }
    while (frames-- > 0 && !ended_) show_frame();
  }

  /// The next place: on the way there the board is seen moving.
  void carry(const SE3& from, const SE3& to) {
    const Eigen::Quaterniond a(from.R), b(to.R);
    for (const double s : {0.25, 0.5, 0.75}) show({a.slerp(s, b).toRotationMatrix(), (1 - s) * from.t + s * to.t}, 1);
  }

 private:
  void show_frame() {
    driver_.advance(kPeriod_ns);
    v4l2::test::Shown shown{.sequence = sequence_++, .stamp_ns = driver_.now_ns() - 5'000'000, .picture = bytes_};
    v4l2::test::eventually([&] { return ended_ || driver_.show(shown); });
    v4l2::test::eventually([&] { return ended_ || driver_.queued_buffers() == driver_.buffers(); });  // it was read
  }

  PlayedDriver& driver_;
  BoardPainter painter_;
  bool yuyv_;
  std::mt19937 random_{1};
  Image image_;
  std::vector<std::uint8_t> bytes_;
  std::uint32_t sequence_ = 0;
  std::atomic<bool> ended_{false};
};

struct Case {
  Camera camera;
  std::uint32_t fourcc;
  const char* name;
};

class PlayedCamera : public ::testing::TestWithParam<Case> {};

// Which corner is the first is the finder's choice.
double farthest(const BoardCorners& found, const BoardCorners& truth) {
  const bool turned = (found.front() - truth.front()).norm() > (found.front() - truth.back()).norm();
  double most = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    most = std::max(most, (found[i] - truth[turned ? truth.size() - 1 - i : i]).norm());
  return most;
}

TEST_P(PlayedCamera, IsCalibratedFromTheBoardThatHoldsStill) {
  constexpr int kViews = 10, kUnpluggedBefore = 5;
  const Camera truth = GetParam().camera;
  const std::vector<SE3> places = poses(truth, 3 * kViews, 1);
  PlayedDriver driver;
  driver.offers = {{GetParam().fourcc, {{truth.width, truth.height}}, 10}};
  Film film(driver, truth, GetParam().fourcc);

  const std::unique_ptr<FrameFeed> feed = open_camera_feed(driver, "/dev/video0", {.newest = true, .size = "480x360"});
  std::thread somebody([&] {
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == kUnpluggedBefore) {
        driver.unplug();
        v4l2::test::eventually([&] { return driver.found_none() > 0; });
        driver.plug_in();
        v4l2::test::eventually([&] { return driver.streams(); });
      }
      if (i > 0) film.carry(places[i - 1], places[i]);
      film.show(places[i], 6);
    }
    feed->interrupt();
  });
  ::testing::internal::CaptureStdout();
  const WatchedBoard watched = watch_board(*feed, kBoard, kViews);
  film.end();
  somebody.join();
  const std::string told = ::testing::internal::GetCapturedStdout();

  ASSERT_EQ(watched.views.size(), static_cast<std::size_t>(kViews)) << told;
  EXPECT_THAT(told, AllOf(HasSubstr("view 1 taken, around ("), HasSubstr("; next: the "), HasSubstr("view 10 taken")));
  std::mt19937 random(0);
  std::size_t place = 0;
  for (const BoardCorners& view : watched.views) {  // each is of a place where the board was held, in their order
    while (place < places.size() && farthest(view, corners_seen(truth, places[place], 0, random)) > 0.5) ++place;
    ASSERT_LT(place, places.size()) << told;
  }
  const CalibrationResult result = calibrate_camera(watched.views, kBoard, watched.width, watched.height, truth.lens);
  Camera found = result.camera, sigma = result.sigma, right = truth;
  for (int i = 0; i < parameter_count(truth.lens); ++i)
    EXPECT_LT(std::abs(parameter(found, i) - parameter(right, i)), 3 * parameter(sigma, i)) << "parameter " << i;
  EXPECT_LT(sigma.fx, 0.005 * truth.fx);
  EXPECT_LT(result.rms_px, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Formats, PlayedCamera,
                         ::testing::Values(Case{pinhole(), V4L2_PIX_FMT_YUYV, "PinholeYuyv"},
                                           Case{fisheye(), V4L2_PIX_FMT_GREY, "FisheyeGrey"}),
                         [](const auto& i) { return i.param.name; });

}  // namespace
}  // namespace pavo::test
