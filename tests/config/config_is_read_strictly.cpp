#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "pavo/config.h"
#include "tests/support/temporary.h"

namespace pavo {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

Config parsed(const std::string& text) {
  Config config;
  parse_config(text, "FILE", config);
  return config;
}

std::string complaint(const std::string& text) {
  return test::complaint([&] { parsed(text); });
}

TEST(Config, IsReadOverTheDefaults) {
  const Config c = parsed(
      "[engine]\nworkers = 3\nsimd = 'AVX2'\n[undistort]\nalpha = 1\n[features]\noriented = true\n"
      "[odometry]\nseed = 9223372036854775807\nmatch_ratio = 0.7\n[people]\n");
  EXPECT_EQ(c.engine.workers, 3);
  EXPECT_EQ(c.engine.simd, "AVX2");
  EXPECT_EQ(c.undistort.alpha, 1.0);
  EXPECT_TRUE(c.features.oriented);
  EXPECT_EQ(c.odometry.seed, 9223372036854775807u);
  EXPECT_EQ(c.odometry.match_ratio, 0.7);
  EXPECT_EQ(c.features.max_features, Config().features.max_features);
  EXPECT_EQ(to_json(parsed("")), to_json(Config()));
}

TEST(Config, KeysThatDoNotExistAreNamedWithTheNearest) {
  EXPECT_EQ(complaint("[engine]\nwrokers = 1\n"), "FILE:2: no such key: engine.wrokers; did you mean engine.workers?");
  EXPECT_EQ(complaint("[engin]\nworkers = 1\n"), "FILE:2: no such key: engin.workers; did you mean engine.workers?");
  EXPECT_EQ(complaint("workers = 1\n"), "FILE:1: no such key: workers; did you mean engine.workers?");
  EXPECT_EQ(complaint("[odometry]\nworkers = 1\n"),
            "FILE:2: no such key: odometry.workers; did you mean engine.workers?");
  EXPECT_EQ(complaint("[nonsense]\n"), "FILE:1: no such key: nonsense (docs/configuration.md lists all)");
  EXPECT_THAT(complaint("[[engine]]\nworkers = 1\n"), StartsWith("FILE:1: no such key: engine"));
  EXPECT_THAT(complaint("[engine.workers]\nx = 1\n"), StartsWith("FILE:1: engine.workers must be a whole number"));
}

TEST(Config, ValuesOfAnotherTypeOrOutOfRangeAreRefused) {
  const auto refused = [](const std::string& section, const std::string& entry, const std::string& expected) {
    const std::string key = section + "." + entry.substr(0, entry.find(' '));
    EXPECT_EQ(complaint("[" + section + "]\n" + entry + "\n"), "FILE:2: " + key + " must be " + expected);
  };
  refused("engine", "workers = 2.0", "a whole number from 0 to 256");
  refused("engine", "workers = '2'", "a whole number from 0 to 256");
  refused("engine", "workers = 257", "a whole number from 0 to 256");
  refused("engine", "workers = -1", "a whole number from 0 to 256");
  refused("engine", "workers = [2]", "a whole number from 0 to 256");
  refused("engine", "failures_in_a_row = 9000000000", "a whole number from 1 to 1000000000");
  refused("source", "rate_hz = nan", "a number from 0 to 10000");
  refused("source", "rate_hz = inf", "a number from 0 to 10000");
  refused("source", "calibration = 3", "a text");
  refused("source", "mode = 'dead'", "one of auto, every-frame, live");
  refused("people", "enabled = 1", "true or false");
  refused("people", "enabled = 'true'", "true or false");
  refused("odometry", "seed = -1", "a whole number that is not negative");
  refused("odometry", "seed = 1979-05-27", "a whole number that is not negative");
}

TEST(Config, WhatIsNoTomlIsToldInOneLine) {
  EXPECT_THAT(complaint("[engine]\nworkers = \n"), StartsWith("FILE:2: this is not TOML: "));
  EXPECT_THAT(complaint("[engine]\nworkers = 1\nworkers = 2\n"), AllOf(StartsWith("FILE:3: "), HasSubstr("workers")));
  EXPECT_THAT(complaint("\"a\\nb\" = 1\n"), HasSubstr("no such key: a?b"));
  EXPECT_THAT(complaint("\xff\xfe"), StartsWith("FILE:1: "));
  EXPECT_THAT(complaint("[.engine]\n"), HasSubstr("this is not TOML: "));  // an assertion of toml++ 3.3's
  EXPECT_THAT(complaint("[engine.\xc3\xa9]\n"), HasSubstr("this is not TOML: "));
  EXPECT_EQ(parsed("[engine] # \xc3\xa9\nsimd = '\xc3\xa9'\n").engine.simd, "\xc3\xa9");
  EXPECT_LT(complaint("\"" + std::string(100'000, 'x') + "\" = 1\n").size(), 300u);
}

TEST(Config, FilesThatCannotBeReadAreNamed) {
  Config config;
  EXPECT_EQ(test::complaint([&] { read_config("/nowhere/c.toml", config); }),
            "/nowhere/c.toml: cannot be read: No such file or directory");
  const test::TemporaryFolder folder;
  EXPECT_THAT(test::complaint([&] { read_config(folder.file(""), config); }), HasSubstr("directory"));
  const std::string big = folder.write("big.toml", std::string((1 << 20) + 1, '#'));
  EXPECT_THAT(test::complaint([&] { read_config(big, config); }), HasSubstr("more than 1048576 bytes"));
}

TEST(Config, TextIsReadAsTheKeysOwnType) {
  Config c;
  set_from_text(c, "engine.workers", "4", "--workers");
  set_from_text(c, "source.rate_hz", "12.5", "--rate");
  set_from_text(c, "source.calibration", "42", "--calibration");
  set_from_text(c, "people.enabled", "false", "--no-people");
  EXPECT_EQ(c.engine.workers, 4);
  EXPECT_EQ(c.source.rate_hz, 12.5);
  EXPECT_EQ(c.source.calibration, "42");
  EXPECT_FALSE(c.people.enabled);
  const auto told = [&](const char* key, const char* text) {
    return test::complaint([&] { set_from_text(c, key, text, "--option"); });
  };
  EXPECT_EQ(told("engine.workers", "4x"), "--option must be a whole number from 0 to 256, not '4x'");
  EXPECT_EQ(told("engine.workers", ""), "--option must be a whole number from 0 to 256, not ''");
  EXPECT_EQ(told("people.enabled", "yes"), "--option must be true or false, not 'yes'");
  EXPECT_EQ(told("odometry.tracker", "a\nb"), "--option must be one of descriptor, klt, not 'a?b'");
  EXPECT_EQ(told("engine.worker", "1"), "--option: no such key: engine.worker; did you mean engine.workers?");
  EXPECT_EQ(c.engine.workers, 4);
}

TEST(Config, AsJsonHoldsEveryKeyAndReadsBack) {
  Config config;
  config.odometry.seed = 12;
  const auto json = to_json(config);
  std::string toml;
  std::size_t keys = 0;
  for (const auto& [section, entries] : json.items()) {
    toml += "[" + section + "]\n";
    for (const auto& [name, value] : entries.items()) {
      toml += name + " = " + value.dump() + "\n";
      ++keys;
    }
  }
  EXPECT_EQ(keys, settings(config).size());
  EXPECT_EQ(to_json(parsed(toml)), json);
}

TEST(Config, DefaultsAreWithinTheirRanges) {
  Config config;
  for (const Setting& setting : settings(config)) {
    EXPECT_FALSE(setting.help.empty()) << setting.key;
    if (const auto* const* text = std::get_if<std::string*>(&setting.value)) {
      if (!setting.choices.empty()) {
        EXPECT_THAT(setting.choices, ::testing::Contains(**text)) << setting.key;
      }
    } else if (setting.minimum != setting.maximum) {
      const double value = std::visit(
          [](auto* v) {
            if constexpr (std::is_arithmetic_v<std::remove_pointer_t<decltype(v)>>) return static_cast<double>(*v);
            return 0.0;
          },
          setting.value);
      EXPECT_GE(value, setting.minimum) << setting.key;
      EXPECT_LE(value, setting.maximum) << setting.key;
    }
  }
}

}  // namespace
}  // namespace pavo
