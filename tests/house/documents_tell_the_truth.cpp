// What the documentation promises is what the program does.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "pavo/config.h"

namespace pavo {
namespace {

struct Row {
  std::string fallback, range;
};

/// The table of docs/configuration.md: | `key` | default | range | ...
std::map<std::string, Row> documented() {
  static const std::regex form(R"re(^\| `([a-z_]+\.[a-z_]+)` \| `([^|]*)` \| ([^|]*) \|.*\|$)re");
  std::ifstream file(std::string(PAVO_SOURCE_DIR) + "/docs/configuration.md");
  EXPECT_TRUE(file.good()) << "docs/configuration.md is not there";
  std::map<std::string, Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, form)) continue;
    EXPECT_TRUE(rows.insert({match[1], {match[2], match[3]}}).second) << match[1] << " stands there twice";
  }
  return rows;
}

double number_of(const Setting& setting) {
  return std::visit(
      [](auto* value) {
        if constexpr (std::is_arithmetic_v<std::remove_pointer_t<decltype(value)>>) return static_cast<double>(*value);
        return 0.0;
      },
      setting.value);
}

void expect_default(const Setting& setting, const std::string& told) {
  if (const auto* const* text = std::get_if<std::string*>(&setting.value)) {
    EXPECT_EQ(told, "\"" + **text + "\"") << setting.key;
  } else if (const auto* const* flag = std::get_if<bool*>(&setting.value)) {
    EXPECT_EQ(told, **flag ? "true" : "false") << setting.key;
  } else {
    EXPECT_EQ(std::stod(told), number_of(setting)) << setting.key;
  }
}

TEST(Documents, NameEveryKeyItsDefaultAndItsRange) {
  const auto rows = documented();
  Config config;
  const std::vector<Setting> all = settings(config);
  EXPECT_EQ(rows.size(), all.size()) << "docs/configuration.md names other keys than there are";
  for (const Setting& setting : all) {
    const auto row = rows.find(std::string(setting.key));
    ASSERT_NE(row, rows.end()) << setting.key << " is not in docs/configuration.md";
    expect_default(setting, row->second.fallback);
    for (const std::string_view choice : setting.choices)
      EXPECT_THAT(row->second.range, ::testing::HasSubstr(fmt::format("`{}`", choice))) << setting.key;
    static const std::regex range("(-?[0-9.]+) to ([0-9.]+)");
    std::smatch match;
    if (setting.minimum == setting.maximum) continue;
    ASSERT_TRUE(std::regex_match(row->second.range, match, range)) << setting.key << ": " << row->second.range;
    EXPECT_EQ(std::stod(match[1]), setting.minimum) << setting.key;
    EXPECT_EQ(std::stod(match[2]), setting.maximum) << setting.key;
  }
}

TEST(Documents, ShowAnExampleThatIsValid) {
  std::ifstream file(std::string(PAVO_SOURCE_DIR) + "/docs/configuration.md");
  std::string toml;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) {
      inside = line == "```toml";
    } else if (inside) {
      toml += line + "\n";
    }
  }
  EXPECT_FALSE(toml.empty());
  Config config;
  EXPECT_NO_THROW(parse_config(toml, "docs/configuration.md", config));
  EXPECT_EQ(config.engine.workers, 4);
}

}  // namespace
}  // namespace pavo
