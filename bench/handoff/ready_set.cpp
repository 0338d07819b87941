// Ours: the set of slots in one word, and the event count on a futex, as the engine's workers use them.
#include "engine/ready_set.h"

#include "bench/handoff/competitors.h"
#include "engine/event_count.h"

namespace pavo::bench {
namespace {

class Ours final : public Handoff {
 public:
  void put(int token) override {
    set_.put(token);
    there_.notify_one();
  }
  int take() override {
    for (;;) {
      if (const auto token = set_.take(oldest_)) return taken(*token);
      const EventCount::Key key = there_.prepare();
      if (const auto token = set_.take(oldest_)) {
        there_.cancel();
        return taken(*token);
      }
      there_.wait(key);
    }
  }

 private:
  int taken(int token) {
    oldest_ = (token + 1) % kTokens;  // tokens go round in the order of their slots
    return token;
  }

  ReadySet set_;
  EventCount there_;
  int oldest_ = 0;
};

}  // namespace

std::unique_ptr<Handoff> ready_set() {
  return std::make_unique<Ours>();
}

}  // namespace pavo::bench
