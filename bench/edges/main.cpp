// What should an edge between two stages be made of: a set of slots in one word, or moodycamel::ConcurrentQueue?
// Every thread takes a token and puts it back, a million times. Checked first: no token is lost or doubled. Then: how
// long does a put and a take cost, how often is a put refused, how often does a token overtake an older one?
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <thread>
#include <vector>

#include "bench/edges/competitors.h"

namespace pavo::bench {
namespace {

constexpr int kTokens = 12;
constexpr int kRounds = 300'000;

struct Result {
  double ns_per_round = 0;
  std::int64_t refused = 0;
  bool complete = true;
};

Result hand_round(Edge& edge, int threads) {
  for (int token = 0; token < kTokens; ++token) edge.put(0, token);
  std::array<std::atomic<int>, kTokens> holders{};
  std::atomic<std::int64_t> refused{0};
  std::atomic<bool> doubled{false};
  const auto start = std::chrono::steady_clock::now();
  {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t)
      workers.emplace_back([&, t] {
        for (int round = 0; round < kRounds; ++round) {
          std::optional<int> token;
          while (!(token = edge.take(t, 0))) std::this_thread::yield();
          if (holders[*token].fetch_add(1) != 0) doubled = true;
          holders[*token].fetch_sub(1);
          while (!edge.put(t, *token)) refused.fetch_add(1);
        }
      });
  }
  Result result;
  result.ns_per_round =
      std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count() / kRounds / threads;
  result.refused = refused;
  std::array<int, kTokens> seen{};
  while (const std::optional<int> token = edge.take(0, 0)) ++seen[*token];
  result.complete = !doubled && std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; });
  return result;
}

// Tokens put in ring order by two threads in turn, as frames are; how many come out behind a younger one?
double share_out_of_order(Edge& edge) {
  int overtaken = 0, total = 0;
  for (int round = 0; round < 10'000; ++round) {
    const int oldest = round % kTokens;
    for (int i = 0; i < kTokens; ++i) edge.put(i % 2, (oldest + i) % kTokens);
    int newest_seen = -1;
    while (const std::optional<int> token = edge.take(round % 2, oldest)) {
      const int age = (*token - oldest + kTokens) % kTokens;
      overtaken += age < newest_seen ? 1 : 0;
      newest_seen = std::max(newest_seen, age);
      ++total;
    }
  }
  return static_cast<double>(overtaken) / total;
}

struct Competitor {
  const char* name;
  std::function<std::unique_ptr<Edge>(int threads)> make;
};

int run() {
  const Competitor competitors[] = {
      {"ready set (ours)", [](int) { return ready_set(); }},
      {"moodycamel::ConcurrentQueue", [](int threads) { return moodycamel_queue(threads); }}};
  for (const int threads : {1, 2, 4}) {
    std::printf("%d threads, %d tokens\n", threads, kTokens);
    for (const Competitor& c : competitors) {
      std::vector<double> ns;
      std::int64_t refused = 0;
      for (int repeat = 0; repeat < 5; ++repeat) {
        const auto edge = c.make(threads);
        const Result r = hand_round(*edge, threads);
        if (!r.complete) {
          std::fprintf(stderr, "%s lost or doubled a token\n", c.name);
          return 1;
        }
        ns.push_back(r.ns_per_round);
        refused += r.refused;
      }
      std::sort(ns.begin(), ns.end());
      const auto edge = c.make(2);
      std::printf("  %-28s %7.1f ns a put and take, %8ld puts refused, %4.1f %% out of order\n", c.name, ns[2],
                  static_cast<long>(refused), 100 * share_out_of_order(*edge));
    }
  }
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main() {
  return pavo::bench::run();
}
