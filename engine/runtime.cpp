#include "engine/runtime.h"

#include <algorithm>
#include <latch>
#include <utility>

#include "engine/realtime.h"

namespace pavo {
namespace {

int default_slots(const PipelineOptions& options, const Graph& graph) {
  const int moving = options.workers + static_cast<int>(graph.minimum_slots);
  constexpr int kReadAhead = 4;  // so that no worker waits for the file system
  return std::min(moving + kReadAhead, ReadySet::kMaxSlots);
}

std::string not_between(const char* what, long low, long high, long is) {
  return std::string(what) + " must be between " + std::to_string(low) + " and " + std::to_string(high) + ", not " +
         std::to_string(is);
}

}  // namespace

std::string PipelineOptions::invalid() const {
  if (workers < 1 || workers > 256) return not_between("workers", 1, 256, workers);
  if (slots < 0 || slots > ReadySet::kMaxSlots)
    return not_between("slots (0: by itself)", 1, ReadySet::kMaxSlots, slots);
  if (live_credits < 0) return "live_credits must not be negative, but is " + std::to_string(live_credits);
  if (failures_in_a_row < 1) return "failures_in_a_row must be at least 1, not " + std::to_string(failures_in_a_row);
  if (stage_limit_ns < 0 || source_limit_ns < 0 || latency_budget_ns < 0) return "a limit of time is negative";
  if (background_nice < 0 || background_nice > 19) return not_between("background_nice", 0, 19, background_nice);
  if (fifo_priority < 0 || fifo_priority > 99) return not_between("fifo_priority (0: none)", 1, 99, fifo_priority);
  for (const int cpu : cpus)
    if (cpu < 0 || cpu > 1023) return not_between("a cpu", 0, 1023, cpu);
  for (const Affinity& a : affinity) {
    if (a.workers.empty()) return "affinity: stage '" + a.stage + "' is given no worker";
    for (const int w : a.workers)
      if (w < 0 || w >= workers) return "affinity of '" + a.stage + "': " + not_between("a worker", 0, workers - 1, w);
  }
  return "";
}

Runtime::Runtime(Graph graph, std::vector<NodeBody> bodies, const PipelineOptions& options, Clock& clock)
    : graph_(std::move(graph)),
      bodies_(std::move(bodies)),
      options_(options),
      clock_(clock),
      slots_(static_cast<std::size_t>(options.slots > 0 ? options.slots : default_slots(options, graph_))),
      ready_(std::make_unique<ReadySet[]>(graph_.nodes.size())),
      watched_(options.trace || options.stage_limit_ns > 0),
      loops_(std::max(1, options.workers + 1)),
      ledger_(static_cast<int>(slots_.size())) {
  if (const std::string wrong = options.invalid(); !wrong.empty()) throw std::invalid_argument(wrong);
  if (slots_.size() < graph_.minimum_slots)
    throw std::invalid_argument("slots: this pipeline needs at least " + std::to_string(graph_.minimum_slots));
  if (options_.live_credits == 0) options_.live_credits = options_.workers + 1;
  posts_ = std::make_unique<Post[]>(posts());
  usual_ns_ = std::make_unique<std::atomic<std::int64_t>[]>(graph_.nodes.size());
  for (std::size_t n = 0; n < graph_.nodes.size(); ++n) usual_ns_[n] = 1'000'000;  // long until it is known
  make_orders();
  make_background();
  for (Slot& slot : slots_) {
    slot.nodes = std::vector<NodeState>(graph_.nodes.size());
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n) slot.nodes[n].pending = initial_pending(graph_.nodes[n]);
  }
  for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
    metrics_.push_back(std::make_unique<StageMetrics>());
    last_seen_.emplace_back(graph_.nodes[n].delayed.size());
    const Graph::Node& node = graph_.nodes[n];
    holders_ += (node.reads_previous() ? 1 : 0) + (node.kind == StageKind::background ? 1 : 0);
    // What the first frames would wait for was never there.
    const auto first_frames = [&](int count) {
      for (int slot = 0; slot < count; ++slot) --slots_[static_cast<std::size_t>(slot)].nodes[n].pending;
    };
    if (node.kind != StageKind::parallel) first_frames(1);
    if (!exact()) continue;
    for (const Graph::DelayedEdge& edge : node.delayed) first_frames(edge.delay);
    if (node.kind == StageKind::background) first_frames(graph_.buffers);
  }
}

Runtime::~Runtime() {
  stop();
  closed_ = true;
  work_there_.notify_all();
  background_there_.notify_all();
  watchdog_.notify_all();
  drained_.notify_all();
}

int Runtime::initial_pending(const Graph::Node& node) const {
  const bool in_background = node.kind == StageKind::background;
  int pending = static_cast<int>(node.producers.size()) + (node.kind != StageKind::parallel ? 1 : 0);
  // Every frame: what flows back to it, and a memory to take it over to.
  if (exact()) pending += static_cast<int>(node.delayed.size()) + (in_background ? 1 : 0);
  return pending;
}

void Runtime::make_orders() {
  rank_.resize(graph_.nodes.size());
  for (std::size_t i = 0; i < graph_.by_priority.size(); ++i) rank_[graph_.by_priority[i]] = static_cast<int>(i);
  for (int worker = 0; worker <= relief(); ++worker) {
    std::vector<std::size_t>& order = orders_.emplace_back(graph_.by_priority);
    if (worker == relief()) break;  // it takes everything
    for (const PipelineOptions::Affinity& a : options_.affinity)
      if (std::find(a.workers.begin(), a.workers.end(), worker) == a.workers.end())
        std::erase_if(order, [&](std::size_t n) { return graph_.nodes[n].name == a.stage; });
  }
  for (const PipelineOptions::Affinity& a : options_.affinity)
    if (std::none_of(graph_.nodes.begin() + 1, graph_.nodes.end(),
                     [&](const Graph::Node& node) { return node.name == a.stage; }))
      throw std::invalid_argument("affinity: there is no stage '" + a.stage + "'");
}

void Runtime::start() {
  if (options_.lock_memory)
    if (const std::string refusal = lock_all_memory(); !refusal.empty()) refusals_.push_back(refusal);
  if (options_.trace) start_trace();
  const auto set_up = std::make_shared<std::latch>(options_.workers);  // the last one may still hold it when we go on
  for (int w = 0; w < options_.workers; ++w)
    workers_.emplace_back([this, w, set_up] {
      set_up_thread(w);
      set_up->count_down();
      work(w);
    });
  if (!background_.empty()) workers_.emplace_back([this] { work_in_background(); });
  if (options_.stage_limit_ns > 0 || options_.source_limit_ns > 0) workers_.emplace_back([this] { watch(); });
  set_up->wait();
  if (options_.fifo_priority > 0) admission_is_fifo_ = make_this_thread_fifo(options_.fifo_priority).empty();
}

void Runtime::start_trace() {
  std::vector<std::string> threads{"source"}, nodes;
  for (int w = 0; w < options_.workers; ++w) threads.push_back("worker " + std::to_string(w));
  threads.insert(threads.end(), {"relief", "background"});
  for (const Graph::Node& node : graph_.nodes) nodes.push_back(node.name);
  options_.trace->start(threads, nodes, {kDropReasons.begin(), kDropReasons.end()});
}

int Runtime::wait_for_slot() {
  const int slot = static_cast<int>(admitted_ % slots_.size());
  if (patience_.look([&] { return slots_[slot].free.load() || stopped(); })) return stopped() ? -1 : slot;
  // Slots come back in the order of the ring. Where every frame counts, it is enough to come when half of those beyond
  // the least are free: once for several frames.
  const int spare = slots() - static_cast<int>(graph_.minimum_slots);
  const int wanted = (slot + (exact() ? spare / 2 : 0)) % slots();
  const std::int64_t start = SteadyClock().now_ns();
  while (!stopped()) {
    wanted_slot_.store(wanted);
    const EventCount::Key key = room_there_.prepare();
    if (slots_[wanted].free.load() || stopped()) {
      room_there_.cancel();
      break;
    }
    room_there_.wait(key);
  }
  wanted_slot_.store(kNoSlot);
  patience_.slept(SteadyClock().now_ns() - start);
  return stopped() ? -1 : slot;
}

bool Runtime::could_start_a_frame() const {
  const int taken = credits_taken();
  if (taken == 0 || taken >= options_.live_credits) return taken == 0;
  return work_there_.sleepers() > 0 && !something_to_do(orders_[static_cast<std::size_t>(relief())]);
}

bool Runtime::wait_for_start(std::int64_t deadline_ns) {
  while (!stopped()) {
    if (could_start_a_frame()) return true;
    if (clock_.now_ns() >= deadline_ns) return false;
    const EventCount::Key key = room_there_.prepare();
    if (could_start_a_frame() || stopped())
      room_there_.cancel();
    else
      clock_.wait(room_there_, key, deadline_ns);
  }
  return false;
}

void Runtime::sleep_until(std::int64_t time_ns) {
  while (!stopped() && clock_.now_ns() < time_ns) {
    const EventCount::Key key = room_there_.prepare();
    if (stopped())
      room_there_.cancel();
    else
      clock_.wait(room_there_, key, time_ns);
  }
}

void Runtime::source_begins(std::int64_t limit_ns) {
  source_limit_ns_.store(limit_ns);
  source_began_ns_ = clock_.now_ns();
  posts_[source_post()].enter(0, admitted_, source_began_ns_);
}

void Runtime::admit(FrameInfo info, const std::string* failure) {
  const int index = static_cast<int>(admitted_ % slots_.size());
  Slot& slot = slots_[index];
  const std::uint64_t lost_by_driver = info.gap;
  info.sequence = admitted_;
  info.gap += dropped_since_;
  if (info.t_sensor_ns == 0) info.t_sensor_ns = info.t_arrival_ns;
  dropped_since_ = 0;
  slot.info = info;
  slot.free = false;
  slot.holds = holders_;
  slot.nodes[0].outcome = failure ? NodeOutcome::failed : NodeOutcome::ok;
  if (failure) {
    slot.nodes[0].message = *failure;
    metrics_[0]->failed.fetch_add(1, std::memory_order_relaxed);
  }
  ++admitted_;
  ledger_.admitted(index, lost_by_driver);
  run_metrics_.in_flight.record(credits_taken());
  const std::int64_t now = clock_.now_ns();
  if (options_.trace)
    options_.trace->record(static_cast<int>(source_post()),
                           {.t_start_ns = source_began_ns_ > 0 ? std::min(source_began_ns_, now) : now,
                            .t_end_ns = now,
                            .sequence = info.sequence,
                            .in_flight = static_cast<std::uint16_t>(credits_taken()),
                            .kind = failure ? TraceEvent::Kind::failed : TraceEvent::Kind::stage});
  wake_workers(complete(0, index, now));
}

void Runtime::drop(DropReason reason, std::uint64_t count) {
  dropped_since_ += count;
  ledger_.dropped(reason, count);
  if (!options_.trace) return;
  const std::int64_t now = clock_.now_ns();
  options_.trace->record(static_cast<int>(source_post()), {.t_start_ns = now,
                                                           .t_end_ns = now,
                                                           .node = static_cast<std::uint32_t>(reason),
                                                           .kind = TraceEvent::Kind::dropped});
}

void Runtime::finish() {
  for (;;) {
    if (all_is_done()) break;
    const EventCount::Key key = done_there_.prepare();
    if (all_is_done())
      done_there_.cancel();
    else
      done_there_.wait(key);
  }
  closed_ = true;
  work_there_.notify_all();
  background_there_.notify_all();
  watchdog_.notify_all();
  drained_.notify_all();
  workers_.clear();
  if (std::exchange(admission_is_fifo_, false)) make_this_thread_ordinary();
  if (error_) std::rethrow_exception(error_);
}

bool Runtime::all_is_done() const {
  return delivered_.load() == admitted_ && std::all_of(background_.begin(), background_.end(),
                                                       [&](const auto& b) { return b->published.load() == admitted_; });
}

void Runtime::stop() {
  stopped_ = true;
  room_there_.notify_all();
  if (wake_source_) wake_source_();
}

void Runtime::forget_latencies() {
  for (const auto& stage : metrics_)
    for (Histogram StageMetrics::*h : {&StageMetrics::wait, &StageMetrics::service, &StageMetrics::cpu})
      ((*stage).*h).clear();
  run_metrics_.end_to_end.clear();
  run_metrics_.age.clear();
  run_metrics_.jitter.clear();
  run_metrics_.in_flight.clear();
}

void Runtime::end_with(std::exception_ptr error) {
  {
    const std::lock_guard lock(error_mutex_);
    if (!error_) error_ = std::move(error);
  }
  stop();
}

}  // namespace pavo
