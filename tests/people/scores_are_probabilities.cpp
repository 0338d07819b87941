#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "stages/people/calibrate.h"
#include "stages/people/linear_svm.h"
#include "types/pedestrian_model.h"

namespace pavo {
namespace {

TEST(Sigmoid, RecoversTheCurveThatTheCasesWereDrawnFrom) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> margin(-3, 3), unit(0, 1);
  std::vector<double> positives, negatives;
  for (int i = 0; i < 40000; ++i) {
    const double m = margin(random);
    (unit(random) < 1 / (1 + std::exp(-(2.5 * m - 1))) ? positives : negatives).push_back(m);
  }
  const Sigmoid s = fit_sigmoid(positives, negatives, 1);
  EXPECT_NEAR(s.slope, 2.5, 0.1);
  EXPECT_NEAR(s.offset, -1, 0.1);
}

TEST(Sigmoid, TheWeightOfPositivesIsThePrior) {
  std::mt19937 random(2);
  std::normal_distribution<double> high(1, 1), low(-1, 1);
  std::vector<double> positives, negatives;
  for (int i = 0; i < 20000; ++i) positives.push_back(high(random)), negatives.push_back(low(random));
  const Sigmoid even = fit_sigmoid(positives, negatives, 1), rare = fit_sigmoid(positives, negatives, 0.1);
  EXPECT_NEAR(rare.slope, even.slope, 0.1);
  EXPECT_NEAR(rare.offset, even.offset + std::log(0.1), 0.15);
}

TEST(Sigmoid, SeparatedClassesStillGiveACurve) {
  const std::vector<double> positives{1, 2, 3}, negatives{-1, -2, -3};
  const Sigmoid s = fit_sigmoid(positives, negatives, 1);
  EXPECT_TRUE(std::isfinite(s.slope));
  EXPECT_GT(s.slope, 0);
}

TEST(Sigmoid, RefusesWhatHasNoRisingCurve) {
  const std::vector<double> high{1, 2, 3}, low{-1, -2, -3};
  EXPECT_THROW(fit_sigmoid(low, high, 1), std::invalid_argument);
  EXPECT_THROW(fit_sigmoid({}, low, 1), std::invalid_argument);
  EXPECT_THROW(fit_sigmoid(high, {}, 1), std::invalid_argument);
}

TEST(Threshold, LetsAsManyThroughAsAllowed) {
  const std::vector<double> alarms{0.5, 3, 1, 2, -1};
  for (std::size_t allowed = 0; allowed < alarms.size(); ++allowed) {
    const double t = threshold_for(alarms, allowed);
    EXPECT_EQ(std::count_if(alarms.begin(), alarms.end(), [&](double a) { return a >= t; }),
              static_cast<std::ptrdiff_t>(allowed));
  }
  EXPECT_TRUE(std::isinf(threshold_for(alarms, 5)));
}

TEST(PedestrianModel, MarginAndProbabilityAreInverse) {
  PedestrianModel model;
  model.slope = 3;
  model.offset = -0.7;
  for (const double p : {0.01, 0.3, 0.5, 0.99}) EXPECT_NEAR(model.probability(model.margin(p)), p, 1e-12);
  EXPECT_EQ(model.margin(0), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(model.margin(1), std::numeric_limits<double>::infinity());
}

TEST(LinearSvm, SeparatesAndForgets) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(-1, 1);
  SvmSamples samples(3);
  for (int i = 0; i < 300; ++i) {
    const std::vector<float> x{value(random), value(random), value(random)};
    samples.add(x, x[0] + 2 * x[1] > 0.5f);
  }
  const std::vector<double> w = fit_linear_svm(samples, 100, 1, 1e-4, {});
  ASSERT_EQ(w.size(), 4u);
  EXPECT_NEAR(w[1] / w[0], 2, 0.2);
  EXPECT_NEAR(w[2] / w[0], 0, 0.1);
  EXPECT_NEAR(w[3] / w[0], -0.5, 0.1);
  int right = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) right += (samples.margin(i, w) > 0) == samples.positive(i);
  EXPECT_GT(right, 295);
  const std::vector<double> again = fit_linear_svm(samples, 100, 1, 1e-4, w);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(again[i], w[i], 0.05 * std::abs(w[0])) << "starting at the end";

  std::vector<char> keep(samples.size(), 0);
  keep[5] = keep[7] = 1;
  const bool fifth = samples.positive(5);
  const double margin = samples.margin(7, w);
  samples.keep_only(keep);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples.positive(0), fifth);
  EXPECT_EQ(samples.margin(1, w), margin);
}

TEST(LinearSvm, NeedsBothClasses) {
  SvmSamples samples(1);
  EXPECT_THROW(fit_linear_svm(samples, 1, 1, 0.1, {}), std::invalid_argument);
  samples.add(std::vector<float>{1}, true);
  EXPECT_THROW(fit_linear_svm(samples, 1, 1, 0.1, {}), std::invalid_argument);
  EXPECT_THROW(samples.add(std::vector<float>{1, 2}, false), std::invalid_argument);
}

}  // namespace
}  // namespace pavo
