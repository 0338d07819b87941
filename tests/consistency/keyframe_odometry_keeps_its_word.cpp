// Standing still, out of sight, turning on the spot: what the keyframe estimator promises where there is no plain
// drive.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "drivers/synthetic/synthetic_street.h"
#include "pavo/plain_loop.h"
#include "stages/decode/decode.h"

namespace pavo::test {
namespace {

/// The street, rendered once a process; nobody walks there.
struct Film {
  Camera camera;
  std::vector<Image> images;
  std::vector<SE3> truth;
};

const Film& film() {
  static const Film rendered = [] {
    SyntheticOptions street;
    street.frames = 45;
    street.width = 400, street.height = 120;
    street.people = false;
    SyntheticStreet sequence(street);
    Film f{.camera = *sequence.info().camera, .images = {}, .truth = sequence.info().groundtruth->T_w_c};
    const Decode decode(street.width, street.height);
    Decode::Scratch scratch;
    EncodedImage encoded;
    for (FrameStamp stamp; sequence.read(encoded, stamp);) decode(encoded, f.images.emplace_back(), scratch);
    return f;
  }();
  return rendered;
}

/// Sees pictures, of the film or others; the true lengths between frames are told, so that the world is the film's.
class Sight {
 public:
  explicit Sight(const Camera& camera = film().camera, const PlainLoopOptions& options = {})
      : loop_(std::make_unique<PlainLoop>(camera, options, std::make_shared<Lengths>(positions_))) {}

  const PoseResult& see(const Image& image, const Eigen::Vector3d& at) {
    positions_->push_back(at);
    return show(image);
  }
  const PoseResult& see(std::size_t film_frame) { return see(film().images[film_frame], film().truth[film_frame].t); }
  bool is_keyframe() const { return loop_->record().is_keyframe; }

 private:
  /// The positions as they come.
  class Lengths final : public StepLength {
   public:
    explicit Lengths(std::shared_ptr<const std::vector<Eigen::Vector3d>> at) : at_(std::move(at)) {}
    double metres(const Step& step) const override {
      return ((*at_)[static_cast<std::size_t>(step.to_frame)] - (*at_)[static_cast<std::size_t>(step.from_frame)])
          .norm();
    }
    bool metric() const override { return true; }

   private:
    std::shared_ptr<const std::vector<Eigen::Vector3d>> at_;
  };

  const PoseResult& show(const Image& image) {
    const PoseResult& pose = (*loop_)({.index = next_, .t_ns = 100'000'000 * next_}, image, {});
    ++next_;
    return pose;
  }

  std::shared_ptr<std::vector<Eigen::Vector3d>> positions_ = std::make_shared<std::vector<Eigen::Vector3d>>();
  std::unique_ptr<PlainLoop> loop_;
  std::int64_t next_ = 0;
};

Image copy_of(const Image& image) {
  Image copy;
  copy.resize(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) std::copy_n(image.row(y), image.width(), copy.row(y));
  return copy;
}

cv::Mat as_mat(const Image& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
          static_cast<std::size_t>(image.stride())};
}

Image gray_picture() {
  Image image = copy_of(film().images[0]);
  as_mat(image).setTo(90);
  return image;
}

double travelled(std::size_t to) {
  double way = 0;
  for (std::size_t i = 1; i <= to; ++i) way += (film().truth[i].t - film().truth[i - 1].t).norm();
  return way;
}

/// The film goes on, and the camera is where it should be.
void expect_followed(Sight& drive, std::size_t from, std::size_t to) {
  for (std::size_t k = from; k < to; ++k) {
    const PoseResult& pose = drive.see(k);
    EXPECT_EQ(pose.quality, Quality::tracked) << k;
    EXPECT_LT((pose.T_w_c.t - film().truth[k].t).norm(), 0.03 * travelled(k)) << k;
  }
}

// The camera stops right at a keyframe: the map moves that when it has adjusted it, and the pose must stay all the
// same.
TEST(KeyframeOdometry, StandsStillToTheBitWhileTheMapMoves) {
  Sight drive;
  std::size_t stop = 0;
  do {
    drive.see(stop);
  } while (stop++ < 12 || !drive.is_keyframe());
  const std::size_t here = stop - 1;
  const SE3 first = drive.see(here).T_w_c;
  for (int k = 0; k < 8; ++k) {
    const PoseResult& pose = drive.see(here);
    EXPECT_EQ(pose.quality, Quality::standing) << k;
    EXPECT_EQ(pose.T_w_c.t, first.t) << k;
    EXPECT_EQ(pose.T_w_c.R, first.R) << k;
  }
  expect_followed(drive, here + 1, here + 6);  // and the start out of it is clean
}

TEST(KeyframeOdometry, CoastsWhereNothingIsSeenAndGoesOnInTheSameMap) {
  Sight drive;
  for (std::size_t k = 0; k < 20; ++k) drive.see(k);
  const Image nothing = gray_picture();
  for (std::size_t k = 20; k < 23; ++k) {
    const PoseResult& pose = drive.see(nothing, film().truth[k].t);
    EXPECT_EQ(pose.quality, Quality::coasting) << k;
    EXPECT_LT((pose.T_w_c.t - film().truth[k].t).norm(), 0.05 * travelled(k)) << k;
  }
  expect_followed(drive, 23, 35);
}

// It covers all that is known for longer than a drive would be waited for; the camera goes nowhere meanwhile.
TEST(KeyframeOdometry, DoesNotTakeALorryThatPassesForANewWorld) {
  Sight drive;
  for (std::size_t k = 0; k < 15; ++k) drive.see(k);
  SE3 here;
  for (int k = 0; k < 4; ++k) here = drive.see(14).T_w_c;
  const Image tarpaulin = copy_of(film().images[40]);  // something else, with texture
  const int width = tarpaulin.width();
  for (int shift = 0; shift < 3 * width / 4; shift += width / 20) {
    Image lorry = copy_of(tarpaulin);
    as_mat(tarpaulin).colRange(0, width - shift).copyTo(as_mat(lorry).colRange(shift, width));
    const PoseResult& pose = drive.see(lorry, film().truth[14].t);
    EXPECT_NE(pose.quality, Quality::relocalising) << shift;
    EXPECT_EQ(pose.T_w_c.t, here.t) << shift;
  }
  for (int k = 0; k < 3; ++k) {
    const PoseResult& pose = drive.see(14);
    EXPECT_EQ(pose.quality, Quality::standing) << k;
    EXPECT_EQ(pose.T_w_c.t, here.t) << k;
  }
  expect_followed(drive, 15, 25);
}

/// The largest error, as a share of the way, behind a car that keeps its place in the picture, `left` px from its side,
/// and has more corners than all the rest.
double error_behind_a_car_ahead(int left) {
  Sight drive;
  cv::Mat car;
  cv::resize(as_mat(film().images[0]), car, {70, 50}, 0, 0, cv::INTER_AREA);
  double worst = 0;
  for (std::size_t k = 0; k < 45; ++k) {
    const Image image = copy_of(film().images[k]);
    const int at = static_cast<int>(std::lround(left + 2 * std::sin(static_cast<double>(k) / 11)));
    car.copyTo(as_mat(image)(cv::Rect(at, 50, car.cols, car.rows)));
    const PoseResult& pose = drive.see(image, film().truth[k].t);
    EXPECT_NE(pose.quality, Quality::standing) << k;
    EXPECT_LT((pose.T_w_c.t - film().truth[k].t).norm(), 0.03 * travelled(k) + 0.02) << k;
    if (k > 4) worst = std::max(worst, (pose.T_w_c.t - film().truth[k].t).norm() / travelled(k));
  }
  return worst;
}

// Neither does the camera stand, nor is the car far away and everything else turning. Where the car hides the end of
// the street, in the middle, that is hardest.
TEST(KeyframeOdometry, IsNotHeldUpByACarAhead) {
  std::vector<double> errors;
  for (const int left : {125, 145, 165, 185, 205}) errors.push_back(error_behind_a_car_ahead(left));
  std::ranges::sort(errors);
  EXPECT_LT(errors[2], 0.015);
}

/// How far the end is off, after a drive in which a car cuts in that hides half of the street and sways a little.
double error_behind_a_wide_car(double farthest_below) {
  PlainLoopOptions options;
  options.odometry.farthest_below = farthest_below;
  options.map.ground.emplace();
  options.map.ground->filter.height_m = 1.65;
  Sight drive(film().camera, options);
  cv::Mat car;
  cv::resize(as_mat(film().images[0]), car, {200, 75}, 0, 0, cv::INTER_AREA);
  double error = 0;
  for (std::size_t k = 0; k < 45; ++k) {
    const Image image = copy_of(film().images[k]);
    const int left = static_cast<int>(std::lround(100 + 3 * std::sin(static_cast<double>(k) / 5)));
    if (k >= 15) car.copyTo(as_mat(image)(cv::Rect(left, 45, car.cols, car.rows)));
    error = (drive.see(image, film().truth[k].t).T_w_c.t - film().truth[k].t).norm() / travelled(k);
  }
  return error;
}

// What goes along with the camera seems infinitely far, and below the horizon there is the ground before that.
TEST(KeyframeOdometry, LooksForNothingBelowTheGround) {
  EXPECT_LT(error_behind_a_wide_car(KeyframeOdometryOptions{}.farthest_below), 0.07);
  EXPECT_GT(error_behind_a_wide_car(1e9), 0.15) << "then this shows nothing";
}

// Lost for long: the map begins anew where the motion model has come to, with the same scale, and never at the origin.
TEST(KeyframeOdometry, BeginsAnewAtTheRightPlaceWhenItWasLost) {
  Sight drive;
  for (std::size_t k = 0; k < 20; ++k) drive.see(k);
  const Image nothing = gray_picture();
  for (std::size_t k = 20; k < 28; ++k) drive.see(nothing, film().truth[k].t);
  int relocalising = 0, tracked = 0;
  for (std::size_t k = 28; k < 45; ++k) {
    const PoseResult& pose = drive.see(k);
    relocalising += pose.quality == Quality::relocalising;
    tracked += pose.quality == Quality::tracked;
    EXPECT_LT((pose.T_w_c.t - film().truth[k].t).norm(), 0.1 * travelled(k)) << k;
  }
  EXPECT_LE(relocalising, 1);
  EXPECT_GE(tracked, 12);
}

/// After a drive, at once three frames on, of which the right `hidden` columns are not seen.
PoseResult after_a_leap(int hidden, int sure_tracked) {
  constexpr std::size_t kFrom = 20;
  PlainLoopOptions options;
  options.odometry.sure_tracked = sure_tracked;
  Sight drive(film().camera, options);
  for (std::size_t k = 0; k <= kFrom; ++k) drive.see(k);
  Image image = copy_of(film().images[kFrom + 3]);
  as_mat(image).colRange(image.width() - hidden, image.width()).setTo(90);
  return drive.see(image, film().truth[kFrom + 3].t);
}

// A camera has inertia: a few points are not believed that say it has leapt. Where all of the picture says so, it has.
TEST(KeyframeOdometry, DoesNotLeapForAHandfulOfPoints) {
  const KeyframeOdometryOptions usual;
  const auto away_from = [](const PoseResult& pose, std::size_t frame) {
    return (pose.T_w_c.t - film().truth[frame].t).norm();
  };
  EXPECT_LT(away_from(after_a_leap(0, usual.sure_tracked), 23), 0.1) << "a step on the street is 0.8 m";
  constexpr int kHidden = 200;
  const PoseResult pose = after_a_leap(kHidden, usual.sure_tracked);
  EXPECT_EQ(pose.quality, Quality::coasting);
  EXPECT_LT(away_from(pose, 21), 0.1);
  EXPECT_EQ(after_a_leap(kHidden, usual.min_tracked).quality, Quality::tracked) << "then this shows nothing";
}

// The last picture as a camera would see it that turns where it is.
TEST(KeyframeOdometry, TurnsOnTheSpotWithoutMoving) {
  constexpr std::size_t kStop = 20;
  Sight drive;
  SE3 before;
  for (std::size_t k = 0; k <= kStop; ++k) before = drive.see(k).T_w_c;
  const Camera& c = film().camera;
  const cv::Matx33d K(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  for (int turn = 1; turn <= 10; ++turn) {
    const double angle = 0.01 * turn, sine = std::sin(angle), cosine = std::cos(angle);
    const cv::Matx33d R(cosine, 0, sine, 0, 1, 0, -sine, 0,
                        cosine);  // of the camera: R maps its points to those before
    Image turned = copy_of(film().images[kStop]);
    cv::warpPerspective(as_mat(film().images[kStop]), as_mat(turned), cv::Mat(K * R.t() * K.inv()), {c.width, c.height},
                        cv::INTER_CUBIC, cv::BORDER_REFLECT);
    const PoseResult& pose = drive.see(turned, film().truth[kStop].t);
    EXPECT_EQ(pose.quality, Quality::tracked) << turn;
    EXPECT_LT((pose.T_w_c.t - before.t).norm(), 0.1) << turn << ": a step on the street is 0.8 m";
    const Eigen::AngleAxisd turned_by(before.R.transpose() * pose.T_w_c.R);
    EXPECT_NEAR(turned_by.angle(), angle, 0.003) << turn;
  }
}

/// A floor with a random pattern on it, 8 m below a camera that looks straight down or ahead at it by `pitch`.
class Floor {
 public:
  explicit Floor(double pitch) : pitch_(pitch) {
    cv::theRNG().state = 7;
    cv::Mat noise(1600, 1600, CV_32F), soft;
    cv::randu(noise, 0, 255);
    cv::GaussianBlur(noise, soft, {0, 0}, 2.0);
    cv::normalize(soft, soft, 10, 245, cv::NORM_MINMAX);
    soft.convertTo(pattern_, CV_8U);
  }
  const Camera& camera() const { return camera_; }

  /// T_floor_camera of a camera at `t` (x, y along the floor, which is z = 0; z is up).
  SE3 place(const Eigen::Vector3d& t) const {
    Eigen::Matrix3d down;  // x right, image's down is back, looking down
    down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    return {down * Eigen::AngleAxisd(pitch_, Eigen::Vector3d::UnitX()).toRotationMatrix(), t};
  }
  Image seen_from(const SE3& T_f_c) const {
    const SE3 T = T_f_c.inverse();
    Eigen::Matrix3d K, on_floor;
    K << camera_.fx, 0, camera_.cx, 0, camera_.fy, camera_.cy, 0, 0, 1;
    on_floor << 1 / kPx_per_m, 0, -800 / kPx_per_m, 0, 1 / kPx_per_m, -800 / kPx_per_m, 0, 0, 1;
    Eigen::Matrix3d plane;
    plane << T.R.col(0), T.R.col(1), T.t;
    const Eigen::Matrix3d H = K * plane * on_floor;
    cv::Matx33d h;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) h(r, c) = H(r, c);
    Image image;
    image.resize(camera_.width, camera_.height);
    cv::Mat into = as_mat(image);
    cv::warpPerspective(pattern_, into, h, into.size(), cv::INTER_AREA, cv::BORDER_REFLECT);
    return image;
  }

 private:
  static constexpr double kPx_per_m = 40;
  double pitch_;
  Camera camera_{.width = 480, .height = 360, .fx = 380, .fy = 380, .cx = 240, .cy = 180};
  cv::Mat pattern_;
};

class OverAFloor : public testing::TestWithParam<std::pair<double, Eigen::Vector3d>> {};

// Everything that is seen lies on one plane: there any number of fundamental matrices fit.
TEST_P(OverAFloor, ItStartsAllTheSame) {
  const auto& [pitch, step] = GetParam();
  const Floor floor(pitch);
  Sight drive(floor.camera());
  const SE3 first = floor.place({0, -3, 8});
  for (int k = 0; k < 25; ++k) {
    const SE3 T_f_c = floor.place(first.t + k * step), truth = first.inverse() * T_f_c;
    const PoseResult& pose = drive.see(floor.seen_from(T_f_c), truth.t);
    EXPECT_EQ(pose.quality, Quality::tracked) << k;
    EXPECT_LT((pose.T_w_c.t - truth.t).norm(), 0.02 + 0.04 * truth.t.norm()) << k << ": " << pose.T_w_c.t.transpose();
    EXPECT_LT(Eigen::AngleAxisd(truth.R.transpose() * pose.T_w_c.R).angle(), 0.01) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Drives, OverAFloor,
                         testing::Values(std::pair(0.0, Eigen::Vector3d(0.25, 0, 0)),         // straight down, sideways
                                         std::pair(0.0, Eigen::Vector3d(0.05, 0.15, -0.12)),  // and sinking
                                         std::pair(-0.6, Eigen::Vector3d(0, 0.3, 0)),         // oblique, ahead
                                         std::pair(-0.4, Eigen::Vector3d(0.2, 0.2, 0.05))));

}  // namespace
}  // namespace pavo::test
