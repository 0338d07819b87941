// What does it cost to hand a token from thread to thread?
//   stream   16 tokens go round between two threads, as slots do: nanoseconds of wall time a hand-over
//   wake-up  the taker sleeps (or spins); from just before put() to behind take(), p50 and p99
//   CPU      what both threads use for one such wake-up
// Checked first: every message arrives once, in its token, none twice. The competitors take turns; medians of rounds.
//
//   bench_handoff [ROUNDS]     default 7; prints a table in Markdown
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <thread>
#include <vector>

#include "bench/handoff/competitors.h"
#include "engine/clock.h"

namespace pavo::bench {
namespace {

constexpr std::int64_t kStreamed = 100'000;
constexpr int kWakeUps = 300;
constexpr std::int64_t kPause_ns = 200'000;  // long enough for the other thread to fall asleep

using Make = std::function<std::unique_ptr<Handoff>()>;

struct Competitor {
  const char* name;
  Make make;
  std::vector<double> stream_ns{}, wake_p50_us{}, wake_p99_us{}, cpu_us{};
};

std::int64_t process_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

// Messages 0, 1, 2, ... travel forth in the tokens, which come back empty. False: one was lost, doubled or overtaken.
bool stream(const Make& make, std::int64_t messages, double* ns) {
  const SteadyClock clock;
  const auto forth = make(), back = make();
  std::array<std::int64_t, kTokens> slots{};
  bool complete = true;
  for (int token = 0; token < kTokens; ++token) back->put(token);
  const std::int64_t start = clock.now_ns();
  {
    const std::jthread consumer([&] {
      for (std::int64_t m = 0; m < messages; ++m) {
        const int token = forth->take();
        complete = complete && slots[static_cast<std::size_t>(token)] == m;
        back->put(token);
      }
    });
    for (std::int64_t m = 0; m < messages; ++m) {
      const int token = back->take();
      slots[static_cast<std::size_t>(token)] = m;
      forth->put(token);
    }
  }
  *ns = static_cast<double>(clock.now_ns() - start) / static_cast<double>(2 * messages);
  return complete;
}

void wake_up(Competitor& competitor) {
  const SteadyClock clock;
  const auto forth = competitor.make(), back = competitor.make();
  for (int token = 0; token < kTokens; ++token) back->put(token);
  std::vector<double> us;
  std::array<std::int64_t, kWakeUps> put_ns{};  // handed over with the tokens
  const std::int64_t cpu_start = process_cpu_ns();
  {
    const std::jthread consumer([&] {
      for (std::size_t i = 0; i < kWakeUps; ++i) {
        const int token = forth->take();
        us.push_back(static_cast<double>(clock.now_ns() - put_ns[i]) * 1e-3);
        back->put(token);
      }
    });
    for (std::size_t i = 0; i < kWakeUps; ++i) {
      const timespec pause{.tv_sec = 0, .tv_nsec = kPause_ns};
      clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
      const int token = back->take();  // there is one, unless the other thread was kept from its core for long
      put_ns[i] = clock.now_ns();
      forth->put(token);
    }
  }
  competitor.cpu_us.push_back(static_cast<double>(process_cpu_ns() - cpu_start) * 1e-3 / kWakeUps);
  std::sort(us.begin(), us.end());
  competitor.wake_p50_us.push_back(us[us.size() / 2]);
  competitor.wake_p99_us.push_back(us[us.size() * 99 / 100]);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

int run(int rounds) {
  Competitor competitors[] = {{"pavo's edge: ready set and event count", ready_set},
                              {"tbb::concurrent_bounded_queue", tbb_bounded_queue},
                              {"moodycamel::BlockingConcurrentQueue", moodycamel_concurrent},
                              {"moodycamel::BlockingReaderWriterQueue", moodycamel_reader_writer},
                              {"boost::lockfree::spsc_queue, yielding", boost_spsc},
                              {"std::mutex and std::condition_variable", mutex_and_condition}};
  for (int round = -1; round < rounds; ++round)
    for (Competitor& c : competitors) {
      double ns = 0;
      if (!stream(c.make, round < 0 ? kStreamed / 10 : kStreamed, &ns)) {
        std::fprintf(stderr, "%s lost, doubled or reordered a message\n", c.name);
        return 1;
      }
      if (round < 0) continue;  // the check, and the warm-up
      c.stream_ns.push_back(ns);
      wake_up(c);
    }
  std::printf("| hand-over | stream, ns | wake-up p50, us | wake-up p99, us | CPU of a wake-up, us |\n");
  std::printf("| --- | --- | --- | --- | --- |\n");
  for (const Competitor& c : competitors)
    std::printf("| %s | %.0f | %.1f | %.1f | %.1f |\n", c.name, median(c.stream_ns), median(c.wake_p50_us),
                median(c.wake_p99_us), median(c.cpu_us));
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc > 1 ? std::max(1, std::atoi(argv[1])) : 7);
}
