#include <cstdlib>
#include <string_view>

#include "drivers/sequences/oxts.h"
#include "drivers/sequences/stamps.h"
#include "drivers/trajectories/trajectory_files.h"
#include "tests/fuzz/fuzz.h"

namespace {

using pavo::fuzz::require;

void check_times(const std::vector<std::int64_t>& times_ns) {
  require(!times_ns.empty(), "there is a time");
  for (std::size_t i = 1; i < times_ns.size(); ++i) require(times_ns[i] > times_ns[i - 1], "times increase");
}

void check_index(const std::vector<pavo::IndexEntry>& entries) {
  require(!entries.empty(), "there is a frame");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    require(!entries[i].file.empty(), "a frame has a file");
    require(i == 0 || entries[i].t_ns > entries[i - 1].t_ns, "times increase");
  }
}

/// Two parsers of seconds, written apart, agree to their rounding.
void compare_seconds(std::string_view text) {
  const auto exact = pavo::parse_seconds(text);
  pavo::fuzz::try_parse([&] { return pavo::parse_times(text, pavo::fuzz::kName); },
                        [&](const std::vector<std::int64_t>& times_ns) {
                          if (times_ns.size() == 1 && exact)
                            require(std::abs(times_ns[0] - *exact) <= 2, "two parsers agree");
                        });
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pavo;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::try_parse([&] { return parse_times(text, fuzz::kName); }, check_times);
  fuzz::try_parse([&] { return parse_timestamps(text, fuzz::kName); }, check_times);
  fuzz::try_parse([&] { return parse_tum_index(text, fuzz::kName); }, check_index);
  fuzz::try_parse([&] { return parse_euroc_index(text, fuzz::kName); }, check_index);
  fuzz::try_parse([&] { return parse_oxts(text, fuzz::kName); },
                  [](const OxtsRecord& record) {
                    const SE3 pose = imu_pose(record, record.latitude_deg);
                    require(pose.t.allFinite() && pose.R.allFinite(), "a record is a pose");
                  });
  compare_seconds(text);
  return 0;
}
