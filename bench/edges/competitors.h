// Two ways to keep the tokens that wait for a stage. Tokens 0 to 31, each at most once in the edge.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

namespace pavo::bench {

class Edge {
 public:
  virtual ~Edge() = default;
  /// False: refused.
  virtual bool put(int producer, int token) = 0;
  /// `oldest`: the slot of the oldest frame in flight.
  virtual std::optional<int> take(int consumer, int oldest) = 0;
};

std::unique_ptr<Edge> ready_set();
std::unique_ptr<Edge> moodycamel_queue(int threads);

}  // namespace pavo::bench
