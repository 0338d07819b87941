#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "bench/people/reference_hog.h"
#include "stages/people/arena_spread.h"
#include "stages/people/person_window.h"
#include "stages/people/scan_hog.h"
#include "stages/people/suppress.h"
#include "tests/people/pictures.h"

namespace pavo {
namespace {

constexpr float kEverything = 2;  // a share that nobody exceeds: no suppression

Detections scan(const Image& image, const PedestrianModel& model, const ScanHogOptions& options) {
  Detections found;
  ScanPeopleHog::Scratch scratch;
  ScanPeopleHog(model, options)(image, found, scratch);
  return found;
}

/// All windows, naively.
Detections naive_scan(const Image& image, const PedestrianModel& model, double step, int border_cells) {
  Detections found;
  hog::Pyramid pyramid;
  pyramid.plan(image.width(), image.height(), step, model.features.tone, hog::Sampling::as_soft_as_training,
               8 * border_cells);
  for (const hog::Level& level : pyramid.levels()) {
    const test::ReferenceHog hog(test::level_of(image.view(), level, model.features.tone), model.features);
    for (int y = 0; y + 16 <= hog.cells_y(); ++y)
      for (int x = 0; x + 8 <= hog.cells_x(); ++x) {
        const std::vector<double> d = hog.window(x, y);
        double margin = static_cast<double>(model.bias);
        for (std::size_t i = 0; i < d.size(); ++i) margin += d[i] * static_cast<double>(model.weights[i]);
        const double p = model.probability(margin);
        const double sx = level.step_x, sy = level.step_y;
        found.push_back(person_in_window(static_cast<float>((8 * x - level.border) * sx),
                                         static_cast<float>((8 * y - level.border) * sy), static_cast<float>(64 * sx),
                                         static_cast<float>(128 * sy), static_cast<float>(p)));
      }
  }
  return found;
}

bool by_place(const PersonBox& a, const PersonBox& b) {
  return std::tuple(a.height, a.y, a.x) < std::tuple(b.height, b.y, b.x);
}

// What one frame looks for and what the next one does, in turn, is together what a whole scan looks for.
TEST(ScanHog, EvenAndOddLevelsAreAllOfThem) {
  const Image image = test::textured(150, 190, 7);
  const PedestrianModel model = test::random_model(7);
  const ScanHogOptions options{.scale_step = 1.2, .threshold = 0, .largest_share = kEverything};
  const ScanPeopleHog scan_levels(model, options);
  Detections even, odd, all = scan(image, model, options);
  ScanPeopleHog::Scratch scratch;
  scan_levels(image, std::nullopt, ScanLevels::even, even, scratch);
  scan_levels(image, std::nullopt, ScanLevels::odd, odd, scratch);
  const auto by_all = [](const PersonBox& a, const PersonBox& b) {
    return std::tuple(a.height, a.y, a.x, a.score) < std::tuple(b.height, b.y, b.x, b.score);
  };
  EXPECT_GT(even.size(), odd.size()) << "the largest level is even";
  EXPECT_GT(odd.size(), all.size() / 4);
  Detections both = even;
  both.insert(both.end(), odd.begin(), odd.end());
  std::sort(both.begin(), both.end(), by_all);
  std::sort(all.begin(), all.end(), by_all);
  ASSERT_EQ(both.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(std::tuple(both[i].x, both[i].y, both[i].height, both[i].score),
              std::tuple(all[i].x, all[i].y, all[i].height, all[i].score));
  }
}

// A window and no more: there is one level, and it is even.
TEST(ScanHog, APictureOfOneLevelHasNoOddOnes) {
  const Image image = test::textured(64, 128, 8);
  const ScanPeopleHog scan_levels(test::random_model(8),
                                  {.scale_step = 3, .border_cells = 0, .threshold = 0, .largest_share = kEverything});
  Detections even, odd{PersonBox{}};
  ScanPeopleHog::Scratch scratch;
  scan_levels(image, std::nullopt, ScanLevels::even, even, scratch);
  scan_levels(image, std::nullopt, ScanLevels::odd, odd, scratch);
  EXPECT_EQ(even.size(), 1u);
  EXPECT_TRUE(odd.empty());
}

TEST(ScanHog, EveryWindowIsThereWithTheScoreOfTheNaiveScan) {
  const Image image = test::textured(150, 190, 1);
  const PedestrianModel model = test::random_model(1);
  for (const int border : {0, 1, 3}) {
    Detections ours =
        scan(image, model, {.scale_step = 1.2, .border_cells = border, .threshold = 0, .largest_share = kEverything});
    Detections naive = naive_scan(image, model, 1.2, border);
    ASSERT_EQ(ours.size(), naive.size()) << border;
    ASSERT_GT(ours.size(), 50u);
    std::sort(ours.begin(), ours.end(), by_place);
    std::sort(naive.begin(), naive.end(), by_place);
    for (std::size_t i = 0; i < ours.size(); ++i) {
      EXPECT_NEAR(ours[i].x, naive[i].x, 1e-3f);
      EXPECT_NEAR(ours[i].y, naive[i].y, 1e-3f);
      EXPECT_NEAR(ours[i].height, naive[i].height, 1e-3f);
      EXPECT_NEAR(ours[i].score, naive[i].score, 0.05f);
    }
  }
}

TEST(ScanHog, TheBorderAddsWindowsAndChangesNone) {
  const Image image = test::textured(160, 150, 7);
  const PedestrianModel model = test::random_model(7);
  Detections with = scan(image, model, {.border_cells = 2, .threshold = 0, .largest_share = kEverything});
  Detections without = scan(image, model, {.border_cells = 0, .threshold = 0, .largest_share = kEverything});
  std::sort(with.begin(), with.end(), by_place);
  std::sort(without.begin(), without.end(), by_place);
  ASSERT_GT(with.size(), 2 * without.size());
  for (const PersonBox& b : without) {
    const auto same = std::lower_bound(with.begin(), with.end(), b, by_place);
    ASSERT_NE(same, with.end());
    EXPECT_EQ(same->x, b.x);
    EXPECT_EQ(same->y, b.y);
    // The pixels beyond an edge are sampled from the image where there is a border, else the last one is repeated.
    EXPECT_NEAR(same->score, b.score, 0.02f);
  }
}

TEST(ScanHog, BoxesAreSuppressedAndInOrder) {
  const Image image = test::textured(260, 300, 2);
  const PedestrianModel model = test::random_model(2);
  Detections all = scan(image, model, {.threshold = 0.3f, .largest_share = kEverything});
  const Detections best = scan(image, model, {.threshold = 0.3f});
  suppress_non_maxima(all, 0.65f);
  ASSERT_EQ(best.size(), all.size());
  for (std::size_t i = 0; i < best.size(); ++i) EXPECT_EQ(best[i].score, all[i].score);
  for (std::size_t i = 1; i < best.size(); ++i) EXPECT_GE(best[i - 1].score, best[i].score);
}

TEST(ScanHog, HelpersDoNotChangeTheResult) {
  const PedestrianModel model = test::random_model(3);
  for (const int threads : {2, 3, 8}) {
    tbb::task_arena arena(threads);
    ArenaSpread helpers(arena);
    const ScanPeopleHog alone(model, {.threshold = 0.2f});
    const ScanPeopleHog helped(model, {.threshold = 0.2f, .spread = &helpers});
    ScanPeopleHog::Scratch a, b;
    for (const auto& [w, h] : {std::pair(200, 260), {330, 140}, {200, 260}}) {
      const Image image = test::textured(w, h, static_cast<unsigned>(w));
      Detections one, many;
      alone(image, one, a);
      helped(image, many, b);
      ASSERT_EQ(one.size(), many.size());
      for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].score, many[i].score);
        EXPECT_EQ(one[i].x, many[i].x);
        EXPECT_EQ(one[i].y, many[i].y);
      }
    }
  }
}

TEST(ScanHog, SmallAndEmptyImagesHoldNobody) {
  const PedestrianModel model = test::random_model(4);
  for (const auto& [w, h] : {std::pair(0, 0), {1, 1}, {63, 400}, {400, 127}})
    EXPECT_TRUE(scan(Image(w, h), model, {.threshold = 0}).empty()) << w << "x" << h;
  EXPECT_EQ(scan(Image(64, 128), model, {.border_cells = 0, .threshold = 0}).size(), 1u);
}

TEST(ScanHog, TheThresholdIsAProbability) {
  const Image image = test::textured(200, 200, 5);
  PedestrianModel model = test::random_model(5);
  model.slope = 0.8;
  model.offset = 0.4;
  model.threshold = 0.7f;
  for (const PersonBox& b : scan(image, model, {})) EXPECT_GE(b.score, 0.7f - 1e-6f);
  EXPECT_GE(scan(image, model, {.threshold = 0.1f}).size(), scan(image, model, {}).size());
  EXPECT_TRUE(scan(image, model, {.threshold = 1}).empty());
}

TEST(ScanHog, RefusesModelsAndOptionsOutOfRange) {
  const auto refused = [](auto change) {
    PedestrianModel model = test::random_model(6);
    ScanHogOptions options;
    change(model, options);
    EXPECT_THROW(ScanPeopleHog(model, options), std::invalid_argument);
  };
  refused([](auto& m, auto&) { m.weights.pop_back(); });
  refused([](auto& m, auto&) { m.weights[7] = std::numeric_limits<float>::quiet_NaN(); });
  refused([](auto& m, auto&) { m.bias = std::numeric_limits<float>::infinity(); });
  refused([](auto& m, auto&) { m.slope = 0; });
  refused([](auto& m, auto&) { m.offset = std::numeric_limits<double>::quiet_NaN(); });
  refused([](auto& m, auto&) { m.features.epsilon = 0; });
  refused([](auto&, auto& o) { o.scale_step = 1; });
  refused([](auto&, auto& o) { o.threshold = 1.5f; });
  refused([](auto&, auto& o) { o.border_cells = -1; });
  refused([](auto&, auto& o) { o.border_cells = 17; });
  refused([](auto&, auto& o) { o.standing = StandingPrior{}; });
}

}  // namespace
}  // namespace pavo
