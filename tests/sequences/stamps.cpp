#include "drivers/sequences/stamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "tests/calibration/error_of.h"

namespace pavo {
namespace {

using test::error_of;
using testing::HasSubstr;

TEST(Seconds, AreExact) {
  EXPECT_EQ(parse_seconds("1305031102.175304"), 1305031102'175304000);
  EXPECT_EQ(parse_seconds("1403715273.262142976"), 1403715273'262142976) << "a double would be off by up to 120 ns";
  EXPECT_EQ(parse_seconds("1.042283e-01"), 104'228'300);
  EXPECT_EQ(parse_seconds("1.042283E+02"), 104'228'300'000);
  EXPECT_EQ(parse_seconds("0"), 0);
  EXPECT_EQ(parse_seconds("-0.5"), -500'000'000);
  EXPECT_EQ(parse_seconds("+.5"), 500'000'000);
  EXPECT_EQ(parse_seconds("7."), 7'000'000'000);
  EXPECT_EQ(parse_seconds("0.0000000005"), 1) << "half a nanosecond is rounded up";
  EXPECT_EQ(parse_seconds("0.00000000049"), 0);
  EXPECT_EQ(parse_seconds("1e-60"), 0);
  EXPECT_EQ(parse_seconds("0e60"), 0);
  EXPECT_EQ(parse_seconds("9223372036.854775806"), INT64_MAX - 1);
}

TEST(Seconds, RefuseWhatIsNoNumberOrTooLarge) {
  for (const char* text : {"",
                           ".",
                           "-",
                           "e5",
                           "1e",
                           "1e+",
                           "1e-",
                           "1.2.3",
                           "1 2",
                           "nan",
                           "inf",
                           "0x10",
                           "1,5",
                           "--1",
                           "+-1",
                           "1e99999999999",
                           "9223372036.854775808",
                           "1e30",
                           "1e+-5",
                           "12345678901234567890123456789012345678901234567890123456789012345"}) {
    EXPECT_EQ(parse_seconds(text), std::nullopt) << text;
  }
}

TEST(Seconds, RoundTripEveryNanosecond) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const auto t_ns = static_cast<std::int64_t>(random() >> (1 + random() % 60));
    char text[40];
    std::snprintf(text, sizeof text, "%lld.%09lld", static_cast<long long>(t_ns / 1'000'000'000),
                  static_cast<long long>(t_ns % 1'000'000'000));
    EXPECT_EQ(parse_seconds(text), t_ns) << text;
  }
}

TEST(DateTime, IsNanosecondsSince1970) {
  EXPECT_EQ(parse_date_time("1970-01-01 00:00:00"), 0);
  EXPECT_EQ(parse_date_time("2011-09-26 13:02:25.594360375"), 1317042145'594360375);
  EXPECT_EQ(parse_date_time("2012-02-29 23:59:59.999999999"), 1330559999'999999999);
  for (const char* text : {"", "2011-09-26", "2011-13-26 13:02:25", "2011-02-29 13:02:25", "2011-09-26 24:02:25",
                           "2011-09-26 13:60:25", "2011-09-26 13:02:61", "2011-09-26 13:02:-5", "2011-09-26T13:02:25",
                           "2011-09-26 13:02:xx", "-011-09-26 13:02:25", "9999-09-26 13:02:25"}) {
    EXPECT_EQ(parse_date_time(text), std::nullopt) << text;
  }
}

TEST(Timestamps, MustIncrease) {
  EXPECT_EQ(parse_timestamps("2011-09-26 13:02:25.5\r\n2011-09-26 13:02:25.6\n", "t").size(), 2);
  EXPECT_THAT(error_of([] { parse_timestamps("2011-09-26 13:02:25.5\n\n2011-09-26 13:02:25.4\n", "t"); }),
              HasSubstr("t:3: the time does not come after"));
  EXPECT_THAT(error_of([] { parse_timestamps("", "t"); }), HasSubstr("t: has no time"));
  EXPECT_THAT(error_of([] { parse_timestamps("now\n", "t"); }), HasSubstr("t:1: expected 'YYYY-MM-DD"));
}

}  // namespace
}  // namespace pavo
