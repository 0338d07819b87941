// Runs the same code on every SIMD target that was compiled and that this machine has.
#pragma once

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdint>
#include <vector>

namespace pavo::test {

/// Forces one target for its lifetime; afterwards the best one is chosen again. Not for tests that run at the same
/// time.
class ForceTarget {
 public:
  explicit ForceTarget(std::int64_t target) { hwy::GetChosenTarget().Update(target); }
  ~ForceTarget() { hwy::GetChosenTarget().DeInit(); }
  ForceTarget(const ForceTarget&) = delete;
  ForceTarget& operator=(const ForceTarget&) = delete;
};

inline std::vector<std::int64_t> simd_targets() {
  return hwy::SupportedAndGeneratedTargets();
}

}  // namespace pavo::test
