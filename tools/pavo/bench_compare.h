// Two results of `pavo bench`: what has changed beyond noise.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace pavo {

/// Reads a result and checks that it is one. Throws std::runtime_error (one line: the file, what was expected).
nlohmann::json read_bench_json(const std::string& path);

/// A line for every figure that differs beyond noise, and one that says how many do not. A difference is beyond noise
/// when the medians are further apart than both spreads (largest - smallest of the repeats) together, and 2 % at
/// least; where both were measured once only, 10 %.
std::string compare_benches(const nlohmann::json& before, const std::string& name, const nlohmann::json& now);

}  // namespace pavo
