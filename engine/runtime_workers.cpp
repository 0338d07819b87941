// The part of the runtime that frames pass through: what a worker does with a token.
#include <pthread.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <string>

#include "engine/realtime.h"
#include "engine/runtime.h"

namespace pavo {
namespace {

constexpr std::uint64_t kCpuSampling = 16;  // reading a thread's CPU time is too dear for every token

// Calls a stage. False: it threw, and `message` says what.
bool succeeds(const std::function<void(const NodeCall&)>& body, const NodeCall& call, std::string& message) {
  try {
    body(call);
    return true;
  } catch (const std::exception& e) {
    message = e.what();
  } catch (...) {
    message = "threw something that is no std::exception";
  }
  return false;
}

}  // namespace

void Runtime::set_up_thread(int worker) {
  pthread_setname_np(pthread_self(), ("pavo-worker" + std::to_string(worker)).c_str());
  const auto ask = [this](const std::string& refusal) {
    const std::lock_guard lock(refusals_mutex_);
    if (!refusal.empty() && std::find(refusals_.begin(), refusals_.end(), refusal) == refusals_.end())
      refusals_.push_back(refusal);
  };
  if (!options_.cpus.empty())
    ask(pin_this_thread(options_.cpus[static_cast<std::size_t>(worker) % options_.cpus.size()]));
  if (options_.fifo_priority > 0) ask(make_this_thread_fifo(options_.fifo_priority));
}

void Runtime::work(int worker) {
  posts_[worker_post(worker)].occupy();
  at_hand_.fetch_add(1);
  for (ShortWait patience; !closed_.load();)
    if (!patience.look([&] { return help_or_take(worker) || closed_.load(); })) sleep(worker, patience);
  at_hand_.fetch_sub(1);
}

// A token, or a turn of another worker's loop: what is nearer to the delivery, and of the same the loop, which is of an
// older frame. So what was begun is ended before something new is.
bool Runtime::help_or_take(int worker) {
  const int loop = loops_.rank();
  if (const auto token = take(worker, loop)) {
    execute(token->first, token->second, worker);
    return true;
  }
  if (loop == OpenLoops::kNone) return false;
  begin_long();
  const bool helped = loops_.help();
  at_hand_.fetch_add(1);
  return helped;
}

std::optional<std::pair<std::size_t, int>> Runtime::take(int worker, int below_rank) {
  const int oldest = static_cast<int>(delivered_.load() % slots_.size());
  for (const std::size_t node : orders_[static_cast<std::size_t>(worker)]) {
    if (rank_[node] >= below_rank) break;
    if (!ready_[node].empty())
      if (const std::optional<int> slot = ready_[node].take(oldest)) return std::pair(node, *slot);
  }
  return std::nullopt;
}

bool Runtime::something_to_do(const std::vector<std::size_t>& nodes) const {
  return loops_.any() || std::any_of(nodes.begin(), nodes.end(), [&](std::size_t n) { return !ready_[n].empty(); });
}

void Runtime::sleep(int worker, ShortWait& patience) {
  at_hand_.fetch_sub(1);
  const EventCount::Key key = work_there_.prepare();
  if (closed_.load() || something_to_do(orders_[static_cast<std::size_t>(worker)])) {
    work_there_.cancel();
  } else {
    if (!exact()) room_there_.notify_one();  // a frame could start
    const std::int64_t start = SteadyClock().now_ns();
    work_there_.wait(key);
    patience.slept(SteadyClock().now_ns() - start);
  }
  at_hand_.fetch_add(1);
}

// Waking somebody up costs more than an empty stage. Where every frame counts, tokens wait for whoever is at hand; who
// begins a long call as the last one at hand has others woken for what waits (begin_long). Both sides announce
// themselves before they look (sequentially consistent), so no token is overlooked. Live, and where not every worker
// may take every token, all who sleep are woken at once.
void Runtime::wake_workers(int count) {
  if (count <= 0) return;
  if (!options_.affinity.empty())
    work_there_.notify_all();
  else if (!exact() || at_hand_.load() == 0)
    work_there_.notify(count);
}

void Runtime::begin_long() {
  if (at_hand_.fetch_sub(1) > 1 || !exact()) return;
  int waiting = 0;
  for (const std::size_t node : graph_.by_priority) waiting += ready_[node].size();
  wake_workers(waiting);
}

// The largest of the last calls, forgotten slowly.
void Runtime::took(std::size_t node, std::int64_t ns) {
  const std::int64_t usual = usual_ns_[node].load(std::memory_order_relaxed);
  usual_ns_[node].store(std::max(ns, usual - usual / 16), std::memory_order_relaxed);
}

int Runtime::rank_of_caller() const {
  for (std::size_t p = 0; p < posts(); ++p)
    if (posts_[p].is_mine()) return rank_[posts_[p].node()];
  return OpenLoops::kNone - 1;
}

void Runtime::execute(std::size_t node, int index, int worker) {
  Slot& slot = slots_[index];
  NodeState& state = slot.nodes[node];
  // For the frame that will come into this slot next. Nobody counts down before this one has passed the node.
  state.pending.store(initial_pending(graph_.nodes[node]));

  const bool first = slot.info.sequence == 0;
  const bool reads_previous = graph_.nodes[node].reads_previous();
  NodeCall call{.info = slot.info,
                .slot = index,
                .previous_slot = reads_previous && !first ? before(index) : -1,
                .previous_ok = 0,
                .worker = worker,
                .outcome = nullptr};
  if (call.previous_slot >= 0)
    for (std::size_t i = 0; i < graph_.nodes[node].previous_producers.size(); ++i)
      if (slots_[call.previous_slot].nodes[graph_.nodes[node].previous_producers[i]].outcome == NodeOutcome::ok)
        call.previous_ok |= std::uint64_t{1} << i;

  const bool long_call = is_long(node);
  if (long_call) begin_long();
  int ready = 0;
  std::int64_t now = 0;
  if (node == graph_.delivery()) {
    now = deliver(slot, call);
  } else if (graph_.nodes[node].kind == StageKind::background) {
    ready += take_over(node, slot, call);
    now = clock_.now_ns();
    release(index);
  } else {
    if (!graph_.nodes[node].delayed.empty()) take_delayed(node, call);
    now = run_body(node, slot, call);
    if (!graph_.nodes[node].delayed.empty()) let_delayed_go(node, call);
    if (call.previous_slot >= 0) release(call.previous_slot);
  }
  if (long_call) at_hand_.fetch_add(1);
  ready += complete(node, index, now);
  wake_workers(options_.affinity.empty() ? ready - 1 : ready);  // this worker takes one of the tokens itself
}

std::int64_t Runtime::run_body(std::size_t node, Slot& slot, const NodeCall& call) {
  const NodeBody& body = bodies_[node];
  NodeState& state = slot.nodes[node];
  StageMetrics& metrics = *metrics_[node];
  Post& post = posts_[worker_post(call.worker)];
  if (options_.disturb) options_.disturb(node, call.info.sequence);
  if (!has_inputs(node, slot)) return call_missed(node, slot, call);

  const bool sampled = slot.info.sequence % kCpuSampling == 0;
  const std::int64_t cpu_start = sampled ? thread_cpu_ns() : 0;
  const std::int64_t start = clock_.now_ns();
  const bool late = options_.latency_budget_ns > 0 && !exact() && body.late &&
                    start - slot.info.t_sensor_ns > options_.latency_budget_ns;
  TraceEvent::Kind kind = late ? TraceEvent::Kind::late : TraceEvent::Kind::stage;
  post.enter(node, slot.info.sequence, start);
  state.outcome = NodeOutcome::ok;
  if (!succeeds(late ? body.late : body.run, call, state.message)) kind = TraceEvent::Kind::failed;
  const std::int64_t end = clock_.now_ns();
  if (kind == TraceEvent::Kind::failed) {
    state.outcome = NodeOutcome::failed;
    metrics.failed.fetch_add(1, std::memory_order_relaxed);
    fall_back(node, call);
  } else if (late) {
    metrics.late.fetch_add(1, std::memory_order_relaxed);
  } else {
    if (sampled) metrics.cpu.record(thread_cpu_ns() - cpu_start);
    metrics.wait.record(start - state.t_ready_ns);
    metrics.service.record(end - start);
  }
  took(node, end - start);
  post.leave();
  if (options_.trace) write_down(node, call, kind, start, end);
  return end;
}

std::int64_t Runtime::call_missed(std::size_t node, Slot& slot, const NodeCall& call) {
  NodeState& state = slot.nodes[node];
  const std::int64_t start = clock_.now_ns();
  state.outcome = NodeOutcome::skipped;
  if (!bodies_[node].missed) return start;
  Post& post = posts_[worker_post(call.worker)];
  post.enter(node, call.info.sequence, start);
  TraceEvent::Kind kind = TraceEvent::Kind::missed;
  if (!succeeds(bodies_[node].missed, call, state.message)) {
    kind = TraceEvent::Kind::failed;
    state.outcome = NodeOutcome::failed;
    metrics_[node]->failed.fetch_add(1, std::memory_order_relaxed);
  }
  post.leave();
  const std::int64_t end = clock_.now_ns();
  if (options_.trace) write_down(node, call, kind, start, end);
  return end;
}

// An in-order stage that threw still owes something sensible in its outputs.
void Runtime::fall_back(std::size_t node, const NodeCall& call) {
  if (!bodies_[node].missed) return;
  try {
    bodies_[node].missed(call);
  } catch (...) {  // the frame has failed already, and the first message is the better one
  }
}

void Runtime::write_down(std::size_t node, const NodeCall& call, TraceEvent::Kind kind, std::int64_t start_ns,
                         std::int64_t end_ns) {
  options_.trace->record(static_cast<int>(worker_post(call.worker)),
                         {.t_start_ns = start_ns,
                          .t_end_ns = end_ns,
                          .wait_ns = start_ns - slots_[call.slot].nodes[node].t_ready_ns,
                          .sequence = call.info.sequence,
                          .node = static_cast<std::uint32_t>(node),
                          .in_flight = 0,
                          .kind = kind});
}

bool Runtime::has_inputs(std::size_t node, const Slot& slot) const {
  const auto& producers = graph_.nodes[node].producers;
  return std::all_of(producers.begin(), producers.end(),
                     [&](std::size_t p) { return slot.nodes[p].outcome == NodeOutcome::ok; });
}

Outcome Runtime::outcome_of(const Slot& slot) const {
  for (std::size_t n = 0; n < graph_.delivery(); ++n)
    if (graph_.nodes[n].kind != StageKind::background && slot.nodes[n].outcome == NodeOutcome::failed)
      return {.failed = true, .stage = graph_.nodes[n].name, .message = slot.nodes[n].message};
  return {};
}

std::int64_t Runtime::deliver(Slot& slot, const NodeCall& call) {
  const Outcome outcome = outcome_of(slot);
  NodeCall delivery = call;
  delivery.outcome = &outcome;
  const std::int64_t start = clock_.now_ns();
  call_delivery(delivery, start);
  failures_row_ = outcome.failed ? failures_row_ + 1 : 0;
  if (failures_row_ == static_cast<std::uint64_t>(options_.failures_in_a_row))
    end_with(std::make_exception_ptr(RunError(std::to_string(failures_row_) + " frames failed in a row, the last in " +
                                              std::string(outcome.stage) + ": " + std::string(outcome.message))));
  const std::int64_t now = clock_.now_ns();
  record_delivery(slot.info, now);
  took(graph_.delivery(), now - start);
  if (options_.trace)
    write_down(graph_.delivery(), call, outcome.failed ? TraceEvent::Kind::failed : TraceEvent::Kind::stage, start,
               now);
  ledger_.delivered(call.slot, outcome.failed);
  delivered_.fetch_add(1);
  if (!exact()) room_there_.notify_one();  // a credit
  done_there_.notify_one();
  drained_.notify_one();
  release(call.slot);
  return now;
}

void Runtime::call_delivery(const NodeCall& call, std::int64_t now_ns) {
  Post& post = posts_[worker_post(call.worker)];
  if (watched_) post.enter(graph_.delivery(), call.info.sequence, now_ns);
  {
    const std::lock_guard lock(delivery_mutex_);
    try {
      if (!delivery_closed_) bodies_[graph_.delivery()].run(call);
    } catch (...) {
      delivery_closed_ = true;
      end_with(std::current_exception());
    }
  }
  post.leave();
}

void Runtime::record_delivery(const FrameInfo& info, std::int64_t now_ns) {
  run_metrics_.end_to_end.record(now_ns - info.t_arrival_ns);
  run_metrics_.age.record(now_ns - info.t_sensor_ns);
  if (info.sequence > 0) {
    const std::int64_t later = (now_ns - last_delivery_ns_) - (info.t_sensor_ns - last_sensor_ns_);
    run_metrics_.jitter.record(later < 0 ? -later : later);
  }
  last_delivery_ns_ = now_ns;
  last_sensor_ns_ = info.t_sensor_ns;
}

int Runtime::complete(std::size_t node, int slot, std::int64_t now_ns) {
  int ready = 0;
  // The slot's own dependents last of all: behind the last of them the slot may hold another frame.
  const bool takes_turns = node != 0 && graph_.nodes[node].kind != StageKind::parallel;
  if (takes_turns) ready += arrive(node, next(slot), now_ns);
  for (const std::size_t dependent : graph_.nodes[node].dependents) ready += arrive(dependent, slot, now_ns);
  return ready;
}

int Runtime::arrive(std::size_t node, int slot, std::int64_t now_ns) {
  NodeState& state = slots_[slot].nodes[node];
  if (state.pending.fetch_sub(1) != 1) return 0;
  state.t_ready_ns = now_ns;
  ready_[node].put(slot);
  return 1;
}

void Runtime::release(int slot) {
  if (slots_[slot].holds.fetch_sub(1) != 1) return;
  slots_[slot].free = true;
  if (wanted_slot_.load() == slot) room_there_.notify_one();
}

}  // namespace pavo
