#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "stages/people/overlap.h"
#include "stages/people/suppress.h"

namespace pavo {
namespace {

bool same(const PersonBox& a, const PersonBox& b) {
  return a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height && a.score == b.score;
}

Detections random_boxes(std::mt19937& random, int n) {
  std::uniform_int_distribution<int> place(0, 60), size(10, 40), score(0, 9);
  Detections boxes;
  for (int i = 0; i < n; ++i)
    boxes.push_back({static_cast<float>(place(random)), static_cast<float>(place(random)),
                     static_cast<float>(size(random)), static_cast<float>(size(random)),
                     static_cast<float>(score(random))});
  return boxes;
}

TEST(Suppression, OfOneBoxInsideAnotherTheBetterStays) {
  Detections boxes{{10, 10, 20, 40, 1}, {12, 14, 10, 20, 2}, {100, 10, 20, 40, 0.5f}};
  suppress_non_maxima(boxes, 0.65f);
  ASSERT_EQ(boxes.size(), 2u);
  EXPECT_EQ(boxes[0].score, 2);
  EXPECT_EQ(boxes[1].score, 0.5f);
}

TEST(Suppression, TheShareIsOfTheSmallerBoxAndExclusive) {
  const PersonBox a{0, 0, 10, 10, 2}, half{5, 0, 10, 10, 1};
  Detections boxes{a, half};
  suppress_non_maxima(boxes, 0.5f);
  EXPECT_EQ(boxes.size(), 2u);
  suppress_non_maxima(boxes, 0.49f);
  EXPECT_EQ(boxes.size(), 1u);
}

TEST(Suppression, WhatStaysIsApartAndWhatGoesIsCovered) {
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    const Detections before = random_boxes(random, 40);
    Detections after = before;
    suppress_non_maxima(after, 0.4f);
    for (std::size_t i = 0; i < after.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_GE(after[j].score, after[i].score);
        EXPECT_LE(intersection_over_smaller(after[i], after[j]), 0.4f);
      }
    for (const PersonBox& b : before) {
      const bool explained = std::any_of(after.begin(), after.end(), [&](const PersonBox& k) {
        return same(k, b) || (k.score >= b.score && intersection_over_smaller(k, b) > 0.4f);
      });
      EXPECT_TRUE(explained);
    }
  }
}

TEST(Suppression, TheOrderOfTheBoxesDoesNotMatter) {
  std::mt19937 random(2);
  for (int round = 0; round < 20; ++round) {
    Detections a = random_boxes(random, 30), b = a;
    std::shuffle(b.begin(), b.end(), random);
    suppress_non_maxima(a, 0.5f);
    suppress_non_maxima(b, 0.5f);
    ASSERT_EQ(a.size(), b.size());
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), same));
  }
}

TEST(Suppression, NothingStaysNothing) {
  Detections none;
  suppress_non_maxima(none, 0.5f);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace pavo
