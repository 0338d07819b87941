// How steady is the engine's beat, and what does pinning or SCHED_FIFO buy? A frame every 10 ms goes through five
// stages of 200 us; between two deliveries there should be 10 ms: what is more or less is the jitter. Checked first:
// that every frame came out. Then: what does an engine cost that waits for frames that do not come?
//
//     bench_realtime [SECONDS]          alone, or beside load: bench/realtime/run.sh starts stress-ng
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "engine/pipeline.h"

namespace pavo::bench {
namespace {

constexpr std::int64_t kPeriod_ns = 10'000'000;
constexpr std::chrono::microseconds kStage(200);

struct Beat {
  std::int64_t number = 0, a = 0, b = 0, c = 0, d = 0, e = 0;
};

class Metronome : public Source<Beat> {
 public:
  Metronome(const Clock& clock, std::int64_t count) : start_ns_(clock.now_ns() + kPeriod_ns), count_(count) {}
  bool read(FrameInfo& info, Beat& beat) override {
    if (next_ == count_) return false;
    info.t_arrival_ns = start_ns_ + next_ * kPeriod_ns;
    beat.number = info.source_index = next_++;
    return true;
  }
  std::optional<std::int64_t> next_arrival_ns() override {
    if (next_ == count_) return std::nullopt;
    return start_ns_ + next_ * kPeriod_ns;
  }

 private:
  std::int64_t start_ns_, count_, next_ = 0;
};

// Its only frame comes at the end of all days.
class Silence : public Source<Beat> {
 public:
  bool read(FrameInfo&, Beat&) override { return false; }
  std::optional<std::int64_t> next_arrival_ns() override { return INT64_MAX; }
};

struct Busy {
  void operator()(const std::int64_t& in, std::int64_t& out) const {
    const auto end = std::chrono::steady_clock::now() + kStage;
    while (std::chrono::steady_clock::now() < end) {
    }
    out = in;
  }
};

void declare(Pipeline<Beat>& pipeline) {
  pipeline.source(writes(&Beat::number));
  pipeline.add("a", reads(&Beat::number), writes(&Beat::a), Busy{}, parallel);
  pipeline.add("b", reads(&Beat::a), writes(&Beat::b), Busy{}, parallel);
  pipeline.add("c", reads(&Beat::a), writes(&Beat::c), Busy{}, parallel);
  pipeline.add("d", reads(&Beat::b), writes(&Beat::d), Busy{}, parallel);
  pipeline.add("e", reads(&Beat::d), writes(&Beat::e), Busy{}, parallel);
}

void measure(const char* name, PipelineOptions options, double seconds) {
  options.workers = 2;
  options.admission = Admission::live;
  SteadyClock clock;
  Pipeline<Beat> pipeline(options, clock);
  declare(pipeline);
  std::int64_t wrong = 0;
  pipeline.deliver([&](const Beat& beat, const FrameInfo&, const Outcome&) { wrong += beat.e != beat.number; });
  Metronome source(clock, static_cast<std::int64_t>(seconds * 1e9) / kPeriod_ns);
  pipeline.run(source);
  const Counts counts = pipeline.counts();
  if (wrong > 0 || counts.in != counts.done + counts.dropped) {
    std::printf("%s: frames were lost or changed\n", name);
    std::exit(1);
  }
  const Quantiles jitter = pipeline.runtime().run_metrics().jitter.quantiles_ms();
  const Quantiles age = pipeline.runtime().run_metrics().end_to_end.quantiles_ms();
  std::printf("| %-28s | %7.3f | %7.3f | %7.3f | %7.3f | %7.3f | %7.3f | %5lu |\n", name, jitter.p50, jitter.p99,
              jitter.max, age.p50, age.p99, age.max, static_cast<unsigned long>(counts.dropped));
  for (const std::string& refusal : pipeline.runtime().refusals()) std::printf("  %s\n", refusal.c_str());
}

double cpu_s() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto s = [](const timeval& t) { return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6; };
  return s(used.ru_utime) + s(used.ru_stime);
}

void measure_idle(double seconds) {
  PipelineOptions options;
  options.workers = 2;
  options.admission = Admission::live;
  options.stage_limit_ns = 1'000'000'000;
  SteadyClock clock;
  Pipeline<Beat> pipeline(options, clock);
  declare(pipeline);
  pipeline.prepare();
  Silence source;
  const double before = cpu_s();
  std::jthread runner([&] { pipeline.run(source); });
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  pipeline.stop();
  runner.join();
  std::printf("\nidle for %.0f s, watchdog on: %.4f %% of a core\n", seconds, 100 * (cpu_s() - before) / seconds);
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  using pavo::PipelineOptions;
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10;
  std::printf("| scheduling                   | jitter p50 ms | p99 | max | latency p50 ms | p99 | max | dropped |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  PipelineOptions plain, pinned, fifo, both;
  pinned.cpus = both.cpus = {0, 1};
  fifo.fifo_priority = both.fifo_priority = 50;
  both.lock_memory = true;
  pavo::bench::measure("as everybody", plain, seconds);
  pavo::bench::measure("pinned", pinned, seconds);
  pavo::bench::measure("SCHED_FIFO 50", fifo, seconds);
  pavo::bench::measure("pinned, SCHED_FIFO, mlockall", both, seconds);
  pavo::bench::measure_idle(seconds);
}
