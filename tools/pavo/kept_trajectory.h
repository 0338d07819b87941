// The path of a run as far as it is remembered: all of it where it is compared with the truth, else as much as a
// picture needs, however many days the run takes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "types/pose.h"

namespace pavo {

class KeptTrajectory {
 public:
  /// Twice as many as the picture draws; a power of two.
  static constexpr std::size_t kMost = std::size_t{1} << 13;

  /// `all`: every pose is kept. Else every 2^k-th, at most kMost of them, and the last one.
  explicit KeptTrajectory(bool all) : all_(all) {}

  void add(std::int64_t t_ns, const SE3& T_w_c) {
    last_ = T_w_c;
    last_ns_ = t_ns;
    if (count_++ % stride_ != 0) return;
    kept_.T_w_c.push_back(T_w_c);
    kept_.t_ns.push_back(t_ns);
    if (!all_ && kept_.T_w_c.size() == kMost) thin();
  }

  bool empty() const { return count_ == 0; }
  /// The identity where there is none yet.
  const SE3& last() const { return last_; }
  /// The kept ones; the last one of all is among them once finish() was called.
  const Trajectory& trajectory() const { return kept_; }
  void finish() {
    if (empty() || (count_ - 1) % stride_ == 0) return;
    kept_.T_w_c.push_back(last_);
    kept_.t_ns.push_back(last_ns_);
  }

 private:
  void thin() {
    for (std::size_t i = 0; 2 * i < kept_.T_w_c.size(); ++i) {
      kept_.T_w_c[i] = kept_.T_w_c[2 * i];
      kept_.t_ns[i] = kept_.t_ns[2 * i];
    }
    kept_.T_w_c.resize(kMost / 2);
    kept_.t_ns.resize(kMost / 2);
    stride_ *= 2;
  }

  bool all_;
  Trajectory kept_;
  SE3 last_;
  std::int64_t last_ns_ = 0;
  std::uint64_t count_ = 0, stride_ = 1;
};

}  // namespace pavo
