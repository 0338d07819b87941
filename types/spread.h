// A loop whose turns several may take: how a stage lets others help with one frame, without knowing who they are.
#pragma once

#include <memory>

namespace pavo {

/// Thread-safe; several loops may run at once, each with its own scratch.
class Spread {
 public:
  virtual ~Spread() = default;

  /// How many may be at work in one loop, the caller among them; at least 1.
  virtual int hands() const = 0;

  /// turn(hand, i) for every i in [0, turns), each once, in any order, by whoever is free, the caller too. `hand`
  /// is below hands(), and never the same for two that are at work at once: scratch memory goes by
  /// it. Returns when all turns are done; what a turn throws is thrown here. Allocates nothing.
  template <class Turn>
  void operator()(int turns, Turn& turn) {
    run(turns, const_cast<void*>(static_cast<const void*>(std::addressof(turn))),
        [](void* context, int hand, int i) { (*static_cast<Turn*>(context))(hand, i); });
  }

 protected:
  using Call = void (*)(void* context, int hand, int i);
  virtual void run(int turns, void* context, Call call) = 0;
};

/// The same where there may be nobody to help: the caller, hand 0, makes all turns.
template <class Turn>
void spread_or_not(Spread* spread, int turns, Turn& turn) {
  if (spread) return (*spread)(turns, turn);
  for (int i = 0; i < turns; ++i) turn(0, i);
}

}  // namespace pavo
