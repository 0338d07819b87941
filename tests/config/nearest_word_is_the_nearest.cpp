#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "pavo/nearest_word.h"

namespace pavo {
namespace {

// By the definition, without tables.
std::size_t distance(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return a.size() + b.size();
  std::size_t d = std::min({distance(a.substr(1), b) + 1, distance(a, b.substr(1)) + 1,
                            distance(a.substr(1), b.substr(1)) + (a[0] == b[0] ? 0 : 1)});
  if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0])
    d = std::min(d, distance(a.substr(2), b.substr(2)) + 1);
  return d;
}

TEST(NearestWord, KnowsTheUsualSlips) {
  const std::vector<std::string_view> words{"run", "eval", "synth", "--workers", "--seed"};
  EXPECT_EQ(nearest_word("rnu", words), "run");
  EXPECT_EQ(nearest_word("evla", words), "eval");
  EXPECT_EQ(nearest_word("sinth", words), "synth");
  EXPECT_EQ(nearest_word("--worker", words), "--workers");
  EXPECT_EQ(nearest_word("--wrokerss", words), "--workers");
  EXPECT_EQ(nearest_word("quaternion", words), "");
  EXPECT_EQ(nearest_word("", std::vector<std::string_view>{}), "");
}

TEST(NearestWord, TakesTheFirstOfEqualOnes) {
  EXPECT_EQ(nearest_word("cat", std::vector<std::string_view>{"bat", "hat"}), "bat");
  EXPECT_EQ(nearest_word("cat", std::vector<std::string_view>{"bat", "cat"}), "cat");
}

TEST(NearestWord, AgreesWithTheDefinition) {
  std::mt19937 random(1);
  const auto word = [&] {
    std::string text(random() % 6, 'a');
    for (char& c : text) c = static_cast<char>('a' + random() % 3);
    return text;
  };
  for (int n = 0; n < 300; ++n) {
    const std::string asked = word(), first = word(), second = word();
    const std::size_t d1 = distance(asked, first), d2 = distance(asked, second);
    const std::size_t limit = std::max<std::size_t>(2, asked.size() / 3);
    const std::string expected = std::min(d1, d2) > limit ? "" : d1 <= d2 ? first : second;
    EXPECT_EQ(nearest_word(asked, std::vector<std::string_view>{first, second}), expected) << asked;
  }
}

}  // namespace
}  // namespace pavo
