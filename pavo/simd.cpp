#include "pavo/simd.h"

#include <hwy/highway.h>

#include <stdexcept>

namespace pavo {
namespace {

// Highway numbers better targets with lower bits.
std::int64_t best(std::int64_t targets) {
  return targets & -targets;
}

}  // namespace

std::string simd_target() {
  return hwy::TargetName(best(hwy::SupportedTargets() & HWY_TARGETS));
}

void force_simd(const std::string& name) {
  if (name == "auto") return;
  const std::int64_t all = hwy::SupportedTargets() & HWY_TARGETS;
  std::string names;
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {
    const std::int64_t target = best(rest);
    if (name == hwy::TargetName(target)) {
      hwy::DisableTargets(all & ~target);
      return;
    }
    names += std::string(names.empty() ? "" : ", ") + hwy::TargetName(target);
  }
  throw std::runtime_error("--simd (engine.simd): this machine has no target '" + name + "'; it has: " + names);
}

}  // namespace pavo
