// Stages that only take time: a fixed number of turns of a random number generator, calibrated once.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "bench/pipeline/work.h"
#include "engine/clock.h"

namespace pavo::bench {
namespace {

std::uint64_t turned(std::uint64_t x, std::int64_t turns) {
  for (std::int64_t i = 0; i < turns; ++i) x = x * 6364136223846793005u + 1442695040888963407u;
  return x;
}

std::int64_t turns_of(double us) {
  if (us <= 0) return 0;
  constexpr std::int64_t kTurns = 1'000'000;
  std::vector<double> ns;
  std::uint64_t x = 1;
  for (int i = 0; i < 15; ++i) {
    const std::int64_t start = thread_cpu_ns();
    x = turned(x, kTurns);
    ns.push_back(static_cast<double>(thread_cpu_ns() - start) + static_cast<double>(x & 1));
  }
  return std::llround(us * 1e3 * kTurns / *std::min_element(ns.begin(), ns.end()));
}

class Synthetic final : public Work {
 public:
  explicit Synthetic(double stage_us) : turns_(turns_of(stage_us)) {}

  void begin(int tokens, Spread*) override {
    places_.assign(static_cast<std::size_t>(tokens) + 1, {});
    result_ = 0;
  }
  void load(std::int64_t k) override { at(k)[0] = static_cast<std::uint64_t>(k); }
  // Each stage's word depends on those that it reads; that of the last also on the frame before, so order counts.
  void stage(int stage, std::int64_t k) override {
    Place& place = at(k);
    switch (stage) {
      case 0:
        place[1] = turned(place[0], turns_) + 1;
        break;
      case 1:
        place[2] = turned(place[1], turns_) + 2;
        break;
      case 2:
        place[3] = turned(place[1], turns_) + 3;
        break;
      case 3:
        place[4] = turned(place[3], turns_) + 4;
        break;
      default:
        result_ = turned(result_ ^ place[2] ^ place[4], turns_) * 31 + static_cast<std::uint64_t>(k);
    }
  }
  std::uint64_t result() const override { return result_; }

 private:
  struct alignas(64) Place : std::array<std::uint64_t, 8> {};
  Place& at(std::int64_t k) { return places_[static_cast<std::size_t>(k) % places_.size()]; }

  std::int64_t turns_;
  std::vector<Place> places_;
  std::uint64_t result_ = 0;
};

}  // namespace

std::unique_ptr<Work> synthetic_work(double stage_us) {
  return std::make_unique<Synthetic>(stage_us);
}

}  // namespace pavo::bench
