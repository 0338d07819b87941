// The search in bands of rows, by one or by several: the same matches, distances and order.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "stages/matches/nearest.h"
#include "tests/matches/random_features.h"

namespace pavo::test {
namespace {

class Threads final : public Spread {
 public:
  int hands() const override { return 3; }

 private:
  void run(int turns, void* context, Call call) override {
    std::atomic<int> next{0};
    std::vector<std::jthread> threads;
    for (int hand = 0; hand < hands(); ++hand)
      threads.emplace_back([&, hand] {
        for (int i = next++; i < turns; i = next++) call(context, hand, i);
      });
  }
};

class Backwards final : public Spread {
 public:
  int hands() const override { return 3; }

 private:
  void run(int turns, void* context, Call call) override {
    for (int i = turns; i-- > 0;) call(context, i % 3, i);
  }
};

TEST(Nearest, IsTheSameWhoeverHelpsAndInWhateverOrder) {
  Threads threads;
  Backwards backwards;
  MatchNearest::Scratch scratch;
  for (const std::size_t n : {1, 3, 255, 256, 257, 1500}) {
    const Features previous = random_features(n, 1), current = seen_again(previous, 0.05f, 2);
    const auto matched = [&](Spread* spread) {
      Matches matches;
      MatchNearest(MatchNearest::Options{.ratio = 0.9f, .spread = spread})(previous, current, matches, scratch);
      return matches;
    };
    const Matches alone = matched(nullptr);
    EXPECT_TRUE(n == 1 || !alone.empty());
    EXPECT_TRUE(equal(alone, matched(&threads))) << n;
    EXPECT_TRUE(equal(alone, matched(&backwards))) << n;
  }
}

}  // namespace
}  // namespace pavo::test
