#include <nlohmann/json.hpp>
#include <string_view>

#include "pavo/config.h"
#include "tests/fuzz/fuzz.h"

namespace {

using pavo::fuzz::require;

/// Every value is one that the key's description allows, and is what another reading gives.
void check_config(pavo::Config config) {
  for (const pavo::Setting& setting : pavo::settings(config)) {
    if (const auto* const* text = std::get_if<std::string*>(&setting.value)) {
      bool allowed = setting.choices.empty();
      for (const std::string_view choice : setting.choices) allowed = allowed || choice == **text;
      require(allowed, "a text is one of its choices");
    }
    if (setting.minimum == setting.maximum) continue;
    const double value = std::visit(
        [](auto* v) {
          if constexpr (std::is_arithmetic_v<std::remove_pointer_t<decltype(v)>>) return static_cast<double>(*v);
          return 0.0;
        },
        setting.value);
    require(value >= setting.minimum && value <= setting.maximum, "a number is in its range");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pavo;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::try_parse(
      [&] {
        Config config;
        parse_config(text, fuzz::kName, config);
        Config again;
        parse_config(text, fuzz::kName, again);
        require(to_json(config) == to_json(again), "the same text gives the same config");
        return config;
      },
      check_config);
  return 0;
}
