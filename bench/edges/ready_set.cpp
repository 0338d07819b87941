#include "engine/ready_set.h"

#include "bench/edges/competitors.h"

namespace pavo::bench {
namespace {

class Ours final : public Edge {
 public:
  bool put(int, int token) override {
    set_.put(token);
    return true;
  }
  std::optional<int> take(int, int oldest) override { return set_.take(oldest); }

 private:
  ReadySet set_;
};

}  // namespace

std::unique_ptr<Edge> ready_set() {
  return std::make_unique<Ours>();
}

}  // namespace pavo::bench
