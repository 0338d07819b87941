#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "stages/matches/klt.h"

namespace pavo::test {
namespace {

/// A smooth texture, moved by (dx, dy) pixels.
Image texture(int width, int height, double dx, double dy) {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = x - dx, v = y - dy;
      const double value = 128 + 40 * std::sin(0.31 * u + 0.07 * v) + 40 * std::cos(0.23 * v - 0.11 * u) +
                           30 * std::sin(0.011 * u * std::cos(0.02 * v) + 0.17 * v);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    }
  return image;
}

std::vector<Keypoint> grid() {
  std::vector<Keypoint> keypoints;
  for (int y = 30; y < 130; y += 20)
    for (int x = 30; x < 210; x += 20) keypoints.push_back({static_cast<float>(x), static_cast<float>(y), 1, 0});
  return keypoints;
}

TEST(Klt, FollowsAShiftToAFractionOfAPixel) {
  const Image previous = texture(240, 160, 0, 0), current = texture(240, 160, 3.4, -2.3);
  const std::vector<Keypoint> keypoints = grid();
  Tracks tracks;
  TrackKlt::Scratch scratch;
  TrackKlt()(previous, current, keypoints, {}, tracks, scratch);
  ASSERT_GT(tracks.pairs.size(), keypoints.size() * 8 / 10);
  ASSERT_EQ(tracks.pairs.size(), tracks.previous.size());
  int last = -1;
  for (std::size_t n = 0; n < tracks.pairs.size(); ++n) {
    const PointPair& p = tracks.pairs[n];
    EXPECT_GT(tracks.previous[n], last);
    last = tracks.previous[n];
    EXPECT_EQ(p.x_previous, keypoints[static_cast<std::size_t>(last)].x);
    EXPECT_EQ(p.y_previous, keypoints[static_cast<std::size_t>(last)].y);
    EXPECT_NEAR(p.x_current - p.x_previous, 3.4, 0.1);
    EXPECT_NEAR(p.y_current - p.y_previous, -2.3, 0.1);
  }
}

TEST(Klt, GivesTheSameAgainWithAUsedScratch) {
  const Image previous = texture(240, 160, 0, 0), current = texture(240, 160, 1.5, 1), other = texture(240, 160, 90, 0);
  const std::vector<Keypoint> keypoints = grid();
  Tracks first, again;
  TrackKlt::Scratch scratch, fresh;
  const TrackKlt track;
  track(previous, other, keypoints, {}, again, scratch);
  track(previous, current, keypoints, {}, again, scratch);
  track(previous, current, keypoints, {}, first, fresh);
  ASSERT_EQ(first.previous, again.previous);
  for (std::size_t n = 0; n < first.pairs.size(); ++n) EXPECT_EQ(first.pairs[n].x_current, again.pairs[n].x_current);
}

TEST(Klt, DoesNotFollowWhatIsNotKept) {
  const Image image = texture(240, 160, 0, 0);
  const std::vector<Keypoint> keypoints = grid();
  std::vector<std::uint8_t> keep(keypoints.size(), 1);
  keep[3] = keep[10] = 0;
  Tracks tracks;
  TrackKlt::Scratch scratch;
  TrackKlt()(image, image, keypoints, keep, tracks, scratch);
  EXPECT_EQ(tracks.previous.size(), keypoints.size() - 2);
  for (const int i : tracks.previous) EXPECT_TRUE(i != 3 && i != 10);
  keep.pop_back();
  EXPECT_THROW(TrackKlt()(image, image, keypoints, keep, tracks, scratch), std::invalid_argument);
}

TEST(Klt, DropsTracksWithoutTextureAndThoseThatDoNotReturn) {
  const Image previous = texture(240, 160, 0, 0);
  Image flat(240, 160), unrelated(240, 160);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 240; ++x) {
      flat.at(x, y) = 90;
      unrelated.at(x, y) = static_cast<std::uint8_t>((x * 7919 + y * 104729 + x * y * 31) % 251);
    }
  Tracks tracks;
  TrackKlt::Scratch scratch;
  TrackKlt()(flat, flat, grid(), {}, tracks, scratch);
  EXPECT_TRUE(tracks.pairs.empty());
  TrackKlt::Options unchecked;
  unchecked.max_return_px = 0;
  TrackKlt{unchecked}(previous, unrelated, grid(), {}, tracks, scratch);
  const std::size_t all = tracks.pairs.size();
  TrackKlt()(previous, unrelated, grid(), {}, tracks, scratch);
  EXPECT_LT(tracks.pairs.size(), all / 2);
}

TEST(Klt, LimitsTheDisplacement) {
  TrackKlt::Options options;
  options.max_displacement_px = 2;
  Tracks tracks;
  TrackKlt::Scratch scratch;
  TrackKlt{options}(texture(240, 160, 0, 0), texture(240, 160, 3, 0), grid(), {}, tracks, scratch);
  EXPECT_TRUE(tracks.pairs.empty());
}

TEST(Klt, NothingToFollowIsNoError) {
  const Image image = texture(240, 160, 0, 0), tiny = texture(5, 4, 0, 0), empty;
  Tracks tracks;
  TrackKlt::Scratch scratch;
  TrackKlt()(image, image, {}, {}, tracks, scratch);
  EXPECT_TRUE(tracks.pairs.empty());
  TrackKlt()(empty, empty, grid(), {}, tracks, scratch);
  EXPECT_TRUE(tracks.pairs.empty());
  TrackKlt()(tiny, tiny, grid(), {}, tracks, scratch);
  EXPECT_TRUE(tracks.pairs.empty());
}

TEST(Klt, RefusesWhatCannotBe) {
  Tracks tracks;
  TrackKlt::Scratch scratch;
  EXPECT_THROW(TrackKlt()(texture(240, 160, 0, 0), texture(240, 161, 0, 0), grid(), {}, tracks, scratch),
               std::runtime_error);
  const auto with = [](auto set) {
    TrackKlt::Options options;
    set(options);
    return options;
  };
  EXPECT_THROW(TrackKlt(with([](auto& o) { o.window_px = 20; })), std::invalid_argument);
  EXPECT_THROW(TrackKlt(with([](auto& o) { o.levels = 0; })), std::invalid_argument);
  EXPECT_THROW(TrackKlt(with([](auto& o) { o.iterations = 0; })), std::invalid_argument);
  EXPECT_THROW(TrackKlt(with([](auto& o) { o.epsilon_px = 0; })), std::invalid_argument);
  EXPECT_THROW(TrackKlt(with([](auto& o) { o.max_return_px = -1; })), std::invalid_argument);
  EXPECT_THROW(TrackKlt(with([](auto& o) { o.min_eigenvalue = -1; })), std::invalid_argument);
}

}  // namespace
}  // namespace pavo::test
