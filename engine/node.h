// What the runtime calls: a stage, stripped of its types.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "engine/frame_info.h"

namespace pavo {

inline constexpr int kMaxDelayedReads = 4;  ///< of one stage

/// What a node does with the frame in a slot.
struct NodeCall {
  const FrameInfo& info;
  int slot;
  int previous_slot;          ///< of the frame before; -1 for the first
  std::uint64_t previous_ok;  ///< bit i: the previous frame's i-th `previous` part was written
  int worker;
  const Outcome* outcome;                              ///< for the delivery only
  std::array<int, kMaxDelayedReads> delayed_buffer{};  ///< of the i-th `delayed` part; negative: nothing
};

struct NodeBody {
  std::function<void(const NodeCall&)> run;
  std::function<void(const NodeCall&)> missed;  ///< in-order nodes: the frame has no inputs
  std::function<void(const NodeCall&)>
      late;  ///< the stage's fallback for frames over their latency budget; perhaps none

  // --- of a background node, instead of run
  /// Takes over what it needs of the frame, into its `work`-th memory. False: it needs nothing of it.
  std::function<bool(const NodeCall&, int work)> take;
  /// Makes of that the values in `buffer`. False: it made none.
  std::function<bool(const FrameInfo&, int work, int buffer)> work;
};

}  // namespace pavo
