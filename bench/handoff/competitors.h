// Ways to hand a token from one thread to another that sleeps while there is none.
#pragma once

#include <memory>

namespace pavo::bench {

inline constexpr int kTokens = 16;  ///< 0 to 15; each is in one hand-over at a time

/// One thread puts, another takes.
class Handoff {
 public:
  virtual ~Handoff() = default;
  virtual void put(int token) = 0;
  /// Waits until there is one.
  virtual int take() = 0;
};

std::unique_ptr<Handoff> ready_set();
std::unique_ptr<Handoff> tbb_bounded_queue();
std::unique_ptr<Handoff> moodycamel_concurrent();
std::unique_ptr<Handoff> moodycamel_reader_writer();
std::unique_ptr<Handoff> boost_spsc();
std::unique_ptr<Handoff> mutex_and_condition();

}  // namespace pavo::bench
