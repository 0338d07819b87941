#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>
#include <stdexcept>

#include "stages/people/scan_hog.h"
#include "stages/people/train.h"
#include "tests/people/pictures.h"

namespace pavo {
namespace {

/// A "person": a bright upright bar with a bar across, in clutter.
Image person(int i) {
  Image crop = test::textured(70, 134, static_cast<unsigned>(i) + 100);
  const std::uint8_t gray = static_cast<std::uint8_t>(200 + i % 50);
  for (int y = 20; y < 114; ++y)
    for (int x = 29; x < 41; ++x) crop.at(x, y) = gray;
  for (int y = 40; y < 48; ++y)
    for (int x = 15; x < 55; ++x) crop.at(x, y) = gray;
  return crop;
}

TrainData data(int positives = 30, int negatives = 8) {
  return {.positives = positives,
          .negatives = negatives,
          .load_positive =
              [](int i, Image& image) {
                image = person(i);
                return true;
              },
          .load_negative =
              [](int i, Image& image) {
                image = test::textured(150 + 10 * i, 180, static_cast<unsigned>(i));
                return true;
              }};
}

TrainOptions quick() {
  TrainOptions options;
  options.random_negatives = 80;
  options.scale_step = 1.3;
  options.max_rounds = 3;
  options.hard_margin = -1;
  return options;
}

struct Trained {
  TrainState state;
  std::vector<RoundReport> rounds;
  bool finished = false;
};

Trained train(const TrainData& data, const TrainOptions& options, int threads, TrainState start = {},
              int stop_after = 1000) {
  Trained result;
  result.state = std::move(start);
  tbb::task_arena arena(threads);
  const TrainCallbacks callbacks{
      .progress = [&](const TrainProgress&) { return static_cast<int>(result.rounds.size()) < stop_after; },
      .round = [&](const TrainState&, const RoundReport& r) { result.rounds.push_back(r); }};
  result.finished = train_pedestrians(data, options, arena, callbacks, result.state);
  return result;
}

TEST(Training, FindsThePersonInAPictureThatItNeverSaw) {
  const Trained trained = train(data(), quick(), 1);
  ASSERT_TRUE(trained.finished);
  tbb::task_arena arena(1);
  TrainData held_out = data(6, 3);
  held_out.load_positive = [](int i, Image& image) {
    image = person(i + 500);
    return true;
  };
  const Calibrated calibrated = calibrate_pedestrians(held_out, quick(), arena, trained.state.weights);
  Image scene = test::textured(220, 240, 77);
  const Image someone = person(999);
  for (int y = 0; y < someone.height(); ++y) std::copy_n(someone.row(y), 70, scene.row(y + 60) + 81);
  Detections found;
  ScanPeopleHog::Scratch scratch;
  ScanPeopleHog(calibrated.model)(scene, found, scratch);
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found[0].x + found[0].width / 2, 81 + 35, 10);
  EXPECT_NEAR(found[0].y + found[0].height / 2, 60 + 67, 12);
  EXPECT_GT(calibrated.found, 0.5);
  EXPECT_LE(calibrated.false_alarms_per_image, quick().false_alarms_per_image + 1e-9);
}

TEST(Training, HardExamplesAreFoundOnceAndLearnt) {
  TrainOptions options = quick();
  options.random_negatives = 10;
  const Trained trained = train(data(), options, 1);
  ASSERT_GE(trained.rounds.size(), 2u);
  EXPECT_EQ(trained.rounds[0].new_hard, 0u);
  EXPECT_GT(trained.rounds[1].new_hard, 0u);
  EXPECT_LE(trained.rounds.back().new_false, trained.rounds[1].new_false);
  EXPECT_GT(trained.rounds[1].windows, 100u);
}

TEST(Training, GivesTheSameForAnyNumberOfThreads) {
  const Trained one = train(data(), quick(), 1), three = train(data(), quick(), 3);
  EXPECT_EQ(one.state.weights, three.state.weights);
  EXPECT_EQ(one.state.negatives, three.state.negatives);
}

TEST(Training, ASeedIsATraining) {
  TrainOptions options = quick();
  options.max_rounds = 0;
  const Trained a = train(data(), options, 1);
  options.seed = 2;
  EXPECT_NE(a.state.weights, train(data(), options, 1).state.weights);
}

TEST(Training, GoesOnWhereItWasStopped) {
  TrainOptions options = quick();
  options.done_per_image = 0;  // all rounds
  const Trained whole = train(data(), options, 2);
  for (int stop = 1; stop <= 3; ++stop) {
    const Trained stopped = train(data(), options, 2, {}, stop);
    EXPECT_FALSE(stopped.finished);
    const Trained finished = train(data(), options, 2, stopped.state);
    EXPECT_TRUE(finished.finished);
    ASSERT_EQ(finished.state.round, whole.state.round);
    EXPECT_EQ(finished.state.weights, whole.state.weights) << "stopped after round " << stop - 1;
  }
}

TEST(Training, AStateOfOtherPicturesIsRefused) {
  TrainState state = train(data(), quick(), 1, {}, 1).state;
  state.negatives[0].x = 1000;
  EXPECT_THROW(train(data(), quick(), 1, state), std::runtime_error);
  state.negatives[0] = {99, 0, 0, 0};
  EXPECT_THROW(train(data(), quick(), 1, state), std::runtime_error);
  state.negatives[0] = {0, 99, 0, 0};
  EXPECT_THROW(train(data(), quick(), 1, state), std::runtime_error);
}

TEST(Training, AsManyHardExamplesAsWereAskedFor) {
  TrainOptions options = quick();
  options.random_negatives = 10;
  options.hard_total = 7;
  options.max_rounds = 1;
  EXPECT_EQ(train(data(), options, 2).rounds[1].new_hard, 7u);
}

TEST(Training, PicturesThatCannotBeUsedAreSkipped) {
  TrainData some = data();
  const auto positive = some.load_positive, negative = some.load_negative;
  some.load_positive = [=](int i, Image& image) { return i % 3 != 0 && positive(i, image); };
  some.load_negative = [=](int i, Image& image) { return i % 2 != 0 && negative(i, image); };
  const Trained trained = train(some, quick(), 2);
  EXPECT_TRUE(trained.finished);
  EXPECT_EQ(trained.rounds[0].positives, 2u * 20u);
}

TEST(Training, NothingUsableIsAnError) {
  TrainData none = data();
  none.load_positive = [](int, Image&) { return false; };
  EXPECT_THROW(train(none, quick(), 1), std::runtime_error);
  none = data();
  none.load_negative = [](int, Image&) { return false; };
  EXPECT_THROW(train(none, quick(), 1), std::runtime_error);
  none = data();
  none.load_negative = [](int, Image& image) {
    image.resize(20, 20);
    return true;
  };
  EXPECT_THROW(train(none, quick(), 1), std::runtime_error) << "no window fits";
  EXPECT_THROW(train(data(0), quick(), 1), std::runtime_error);
  EXPECT_THROW(train(data(3, 0), quick(), 1), std::runtime_error);
}

}  // namespace
}  // namespace pavo
