#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/trajectories/speed_file.h"

namespace pavo::test {
namespace {

using testing::HasSubstr;

std::string complaint(const std::string& text) {
  try {
    parse_speed(text, "wheel.csv");
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(SpeedFile, TakesAHeaderCommentsBlanksAndCarriageReturns) {
  const auto samples = parse_speed("t,m/s\r\n# from the wheel\r\n\r\n0.5, 1.25\r\n 1.5 ,-2e0\r\n", "wheel.csv");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].t_ns, 500'000'000);
  EXPECT_EQ(samples[0].m_per_s, 1.25);
  EXPECT_EQ(samples[1].t_ns, 1'500'000'000);
  EXPECT_EQ(samples[1].m_per_s, -2);
  EXPECT_EQ(parse_speed("0,1", "wheel.csv").size(), 1u) << "the header may be missing, and the last line's end";
}

TEST(SpeedFile, NamesTheLineThatIsWrong) {
  EXPECT_THAT(complaint("t,m/s\n0,1\n1,fast\n"), HasSubstr("wheel.csv:3: expected two finite numbers"));
  EXPECT_THAT(complaint("0,1\n1,nan\n"), HasSubstr("wheel.csv:2:"));
  EXPECT_THAT(complaint("0,1\n1,inf\n"), HasSubstr("wheel.csv:2:"));
  EXPECT_THAT(complaint("0,1\n1;2\n"), HasSubstr("wheel.csv:2:"));
  EXPECT_THAT(complaint("0,1\n1,2,3\n"), HasSubstr("wheel.csv:2:"));
  EXPECT_THAT(complaint("0,1\n1e30,2\n"), HasSubstr("wheel.csv:2:"));
  EXPECT_THAT(complaint("2,1\n2,1\n"), HasSubstr("wheel.csv:2: the times must increase"));
  EXPECT_THAT(complaint("2,1\n1,1\n"), HasSubstr("must increase"));
}

TEST(SpeedFile, WithoutASampleIsAnError) {
  EXPECT_THAT(complaint(""), HasSubstr("holds no speed"));
  EXPECT_THAT(complaint("t,m/s\n"), HasSubstr("holds no speed"));
}

TEST(SpeedFile, ThatIsNotThereIsNamed) {
  try {
    read_speed("/nowhere/wheel.csv");
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("/nowhere/wheel.csv"));
  }
}

}  // namespace
}  // namespace pavo::test
