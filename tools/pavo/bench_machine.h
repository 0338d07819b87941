// What a figure was measured on, and whether anybody else was at work there.
#pragma once

#include <cstdint>
#include <string>

namespace pavo {

struct Machine {
  std::string cpu;  ///< as the kernel names it
  int cores = 0;
  std::string governor;  ///< of core 0's frequency; "none" where the kernel has none to offer (virtual machines)
  std::string kernel;
  std::string simd, compiler, version;  ///< what the stages dispatch to; what built pavo; pavo's own
};

Machine this_machine();

/// How much of the machine others used, from its construction to others().
class OtherWork {
 public:
  OtherWork();
  struct Share {
    double percent = 0;         ///< of all cores, by other processes
    double stolen_percent = 0;  ///< by other machines, where this one is virtual
  };
  /// Nothing but zeros where /proc/stat cannot be read.
  Share others() const;

 private:
  struct Ticks {
    std::int64_t busy = 0, stolen = 0, all = 0;
  };
  static Ticks ticks();
  static double own_cpu_s();

  Ticks start_;
  double own_start_s_ = 0;
};

}  // namespace pavo
