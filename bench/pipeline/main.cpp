// What does it cost to bring frames through five stages, and how old are they when they come out?
//
//   bench_pipeline empty|50us|SOURCE [SECONDS] [ROUNDS]     a table in Markdown; default: 50us, 2 seconds a run, 3
//   rounds
//   bench_pipeline alone SOURCE [ROUNDS]                    the latency of a frame that has the machine for itself
//
// SOURCE: a folder of rectified frames that pavo knows, or `synthetic`; pavo's own stages run on its first 100 frames,
// which lie in memory. Checked first: all competitors compute the same. Then each looks for its best number of frames
// in flight (2 to 8) and threads: at full speed for throughput, at 80 % of the best foreign throughput for the p99.
// Then, in turn, ROUNDS times: full speed in ten short sprints, and 50, 80, 100 and 120 % of the best foreign
// throughput, the same frames a second for all. Latencies count from the intended arrival. Medians of the rounds;
// ratios are of runs that followed each other, and medians of those: the machine is another one from minute to minute.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <map>
#include <string>

#include "bench/pipeline/alone.h"
#include "bench/pipeline/competitors.h"
#include "tools/pavo/open_source.h"

namespace pavo::bench {
namespace {

const std::vector<int> kTwo{2}, kTwoOrThree{2, 3};
constexpr double kLoads[] = {50, 80, 100, 120};

struct Latency {
  double p50 = 0, p99 = 0, p999 = 0;
};

struct Entrant {
  Competitor competitor;
  bool ours = false;
  Setup fastest{}, steadiest{};  // at full speed; at 80 %
  double roughly_fps = 0;        // for the length of the next run
  std::vector<double> fps{}, cpu_us{};
  std::map<double, std::vector<Latency>> latency{};
};

double process_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

Latency latency_of(const Feed& feed) {
  const std::vector<double> ms = feed.latencies_ms();
  const auto at = [&](double q) {
    return ms[static_cast<std::size_t>(std::ceil(q * static_cast<double>(ms.size()))) - 1];
  };
  return {at(0.5), at(0.99), at(0.999)};
}

class Contest {
 public:
  Contest(Work& work, double seconds, int rounds, const std::string& what)
      : work_(work), seconds_(seconds), rounds_(rounds) {
    // Threads that wake each other are most of what short stages cost; a longer ring has them do it less often.
    if (what == "empty" || what == "50us") entrants_.push_back({{"pavo, longest ring", run_pavo, 31, 31, kTwo}, true});
    if (what == "empty") entrants_.push_back({{"pavo, longest ring, one worker", run_pavo, 31, 31, {1}}, true});
  }

  void run() {
    check();
    choose_fastest();
    measure_capacity();
    choose_steadiest();
    for (Entrant& e : entrants_) e.fps.clear();
    for (int round = 0; round < rounds_; ++round) {
      sprint();
      if (!too_fast_to_pace()) pace();
    }
    print();
  }

 private:
  static constexpr std::int64_t kWarmUp = 20;

  void check() {
    constexpr std::int64_t kChecked = 60;
    std::uint64_t expected = 0;
    for (Entrant& e : entrants_)
      for (const int tokens : {e.competitor.least_tokens, e.competitor.most_tokens}) {
        Feed feed(kChecked, 0, 0);
        e.competitor.run(work_, feed, {tokens, 2});
        if (&e == entrants_.data())
          expected = work_.result();
        else if (work_.result() != expected)
          throw std::runtime_error(std::string(e.competitor.name) + " computes something else");
        e.roughly_fps = feed.frames_per_second();
      }
  }

  // Frames for so many seconds at so many a second.
  static std::int64_t frames_for(double seconds, double fps) {
    return kWarmUp + std::clamp<std::int64_t>(std::llround(seconds * fps), 40, 2'000'000);
  }

  double full_speed(Entrant& e, const Setup& setup, double seconds, double* cpu_us = nullptr) {
    Feed feed(frames_for(seconds, e.roughly_fps), 0, kWarmUp);
    const double start = process_cpu_s();
    e.competitor.run(work_, feed, setup);
    if (cpu_us) *cpu_us = (process_cpu_s() - start) * 1e6 / static_cast<double>(feed.frames());
    return e.roughly_fps = feed.frames_per_second();
  }

  Latency at_rate(Entrant& e, const Setup& setup, double fps, double seconds) {
    Feed feed(frames_for(seconds, fps), fps, kWarmUp);
    e.competitor.run(work_, feed, setup);
    return latency_of(feed);
  }

  template <class Visit>
  static void each_setup(const Entrant& e, const Visit& visit) {
    for (const int threads : e.competitor.threads)
      for (int tokens = e.competitor.least_tokens; tokens <= e.competitor.most_tokens; ++tokens)
        visit(Setup{tokens, threads});
  }

  void choose_fastest() {
    for (Entrant& e : entrants_) {
      double best = 0;
      each_setup(e, [&](const Setup& setup) {
        const double fps = std::max(full_speed(e, setup, seconds_ / 4), full_speed(e, setup, seconds_ / 4));
        if (fps > best) e.fastest = setup;
        best = std::max(best, fps);
      });
      e.fps.push_back(best);
    }
  }

  // The best of many short runs is a lucky one: what each can keep up is the median of long ones.
  void measure_capacity() {
    for (Entrant& e : entrants_) {
      std::vector<double> fps;
      for (int i = 0; i < 3; ++i) fps.push_back(full_speed(e, e.fastest, seconds_));
      e.fps.back() = median(fps);
      if (!e.ours) capacity_ = std::max(capacity_, e.fps.back());
    }
  }

  void choose_steadiest() {
    for (Entrant& e : entrants_) {
      double best = 1e300;
      e.steadiest = e.fastest;
      if (too_fast_to_pace() || e.fps.back() < 0.8 * capacity_) continue;  // it cannot keep up at all
      each_setup(e, [&](const Setup& setup) {
        const double p99 = std::min(at_rate(e, setup, 0.8 * capacity_, seconds_ / 2).p99,
                                    at_rate(e, setup, 0.8 * capacity_, seconds_ / 2).p99);
        if (p99 < best) e.steadiest = setup;
        best = std::min(best, p99);
      });
    }
  }

  void sprint() {
    constexpr int kSprints = 10;
    for (int i = 0; i < kSprints; ++i)
      for (Entrant& e : entrants_) {
        double cpu_us = 0;
        e.fps.push_back(full_speed(e, e.fastest, seconds_ / 4, &cpu_us));
        e.cpu_us.push_back(cpu_us);
      }
  }

  void pace() {
    for (const double load : kLoads)
      for (Entrant& e : entrants_) e.latency[load].push_back(at_rate(e, e.steadiest, capacity_ * load / 100, seconds_));
  }

  static std::vector<double> ratios(const Entrant& a, const Entrant& b) {
    std::vector<double> all;
    for (std::size_t i = 0; i < a.fps.size(); ++i) all.push_back(a.fps[i] / b.fps[i]);
    return all;
  }

  // Empty stages: nothing would be measured but how well a thread sleeps.
  bool too_fast_to_pace() const { return capacity_ > 50'000; }

  void print() const {
    std::printf("best foreign throughput before that (the loads' 100 %%): %.1f frames a second\n\n", capacity_);
    const Entrant &plain = entrants_[0], &tbb = entrants_[1];
    std::printf("| | frames/s | of plain loop | time, of tbb::parallel_pipeline's | us a frame | CPU us a frame | ");
    std::printf("frames in flight, threads |\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for (const Entrant& e : entrants_) {
      const double fps = median(e.fps);
      std::printf("| %s | %.1f | %.2f | %.3f | %.2f | %.2f | %d, %d |\n", e.competitor.name, fps,
                  median(ratios(e, plain)), median(ratios(tbb, e)), 1e6 / fps, median(e.cpu_us), e.fastest.tokens,
                  e.fastest.threads);
    }
    if (too_fast_to_pace()) return;
    std::printf("\n| end-to-end latency, ms: p50 / p99 / p99.9 |");
    for (const double load : kLoads) std::printf(" %.0f %%: %.1f frames/s |", load, capacity_ * load / 100);
    std::printf(" frames in flight, threads |\n| --- | --- | --- | --- | --- | --- |\n");
    for (const Entrant& e : entrants_) {
      std::printf("| %s |", e.competitor.name);
      for (const double load : kLoads) {
        const auto of = [&](double Latency::*q) {
          std::vector<double> values;
          for (const Latency& l : e.latency.at(load)) values.push_back(l.*q);
          return median(values);
        };
        std::printf(" %.2f / %.2f / %.2f |", of(&Latency::p50), of(&Latency::p99), of(&Latency::p999));
      }
      std::printf(" %d, %d |\n", e.steadiest.tokens, e.steadiest.threads);
    }
  }

  Work& work_;
  double seconds_;
  int rounds_;
  double capacity_ = 0;  // the best foreign one
  std::vector<Entrant> entrants_{
      {{"plain loop", run_plain_loop, 1, 1, kTwo}},
      {{"tbb::parallel_pipeline", run_tbb_pipeline, 2, 8, kTwoOrThree}},
      {{"tbb::parallel_pipeline, nested loops", run_tbb_pipeline_nested, 2, 8, kTwoOrThree}},
      {{"tbb::flow::graph", run_tbb_flow_graph, 2, 8, kTwo}},
      {{"a thread per stage", run_thread_per_stage, 2, 8, kTwo}},
      {{"pavo", run_pavo, 2, 8, kTwo}, true},
  };
};

std::unique_ptr<Work> real_work_on(const std::string& source) {
  constexpr int kFrames = 100;
  return real_work(*open_source(source, {}), kFrames);
}

int run(const std::string& what, double seconds, int rounds) {
  std::unique_ptr<Work> work;
  if (what == "empty") {
    work = synthetic_work(0);
  } else if (what == "50us") {
    work = synthetic_work(50);
  } else {
    work = real_work_on(what);
  }
  Contest(*work, seconds, rounds, what).run();
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  try {
    if (argc > 1 && std::string(argv[1]) == "alone") {
      const auto work = pavo::bench::real_work_on(argc > 2 ? argv[2] : "synthetic");
      pavo::bench::measure_alone(*work, argc > 3 ? std::max(1, std::atoi(argv[3])) : 5);
      return 0;
    }
    return pavo::bench::run(argc > 1 ? argv[1] : "50us", argc > 2 ? std::max(0.1, std::atof(argv[2])) : 2,
                            argc > 3 ? std::max(1, std::atoi(argv[3])) : 3);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bench_pipeline: %s\n", e.what());
    return 1;
  }
}
