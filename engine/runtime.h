// The moving part of the engine: slots go round, tokens wait, workers take them. It knows nodes by number and slots by
// index; Pipeline (pipeline.h) puts frames and stages on top.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "engine/background_jobs.h"
#include "engine/clock.h"
#include "engine/delayed_values.h"
#include "engine/event_count.h"
#include "engine/frame_info.h"
#include "engine/graph.h"
#include "engine/histogram.h"
#include "engine/ledger.h"
#include "engine/node.h"
#include "engine/open_loops.h"
#include "engine/post.h"
#include "engine/ready_set.h"
#include "engine/short_wait.h"
#include "engine/trace.h"

namespace pavo {

enum class Admission {
  every_frame,  ///< the source waits for a free slot: the result is the same on every run, with any number of workers
  live,         ///< the newest frame whenever a credit is free; what it replaces is dropped, and counted
};

struct PipelineOptions {
  int workers = 2;  ///< threads that run stages; the source has the thread that calls run()
  int slots = 0;    ///< frames in the ring, at most 32; 0: enough for every worker, and to read ahead
  Admission admission = Admission::every_frame;
  int live_credits = 0;             ///< frames in flight at once when live; 0: workers + 1
  int failures_in_a_row = 30;       ///< so many frames failing one after the other end the run
  std::int64_t stage_limit_ns = 0;  ///< a stage that holds a frame for longer hangs (HungStage); 0: no watchdog
  std::int64_t source_limit_ns =
      0;  ///< the same for a source's read(), unless it is a device's; 0: it may take its time
  std::int64_t latency_budget_ns =
      0;  ///< live: a stage's fallback `late` is called for frames older than this; 0: never

  int background_nice = 10;  ///< live: of the thread of the background stages, 0 to 19
  /// Which workers a stage may run on, where not all may. Workers count from 0.
  struct Affinity {
    std::string stage;
    std::vector<int> workers;
  };
  std::vector<Affinity> affinity;
  std::vector<int> cpus;     ///< worker i is pinned to the i-th of them, from the front again where they are fewer
  int fifo_priority = 0;     ///< SCHED_FIFO for the workers and the admission, 1 to 99; 0: as everybody
  bool lock_memory = false;  ///< mlockall
  /// Called before every call of a stage; for tests that disturb the timing.
  std::function<void(std::size_t node, std::uint64_t sequence)> disturb;
  Trace* trace = nullptr;  ///< where every call is written down; not owned

  /// One line that says what is wrong, or "".
  std::string invalid() const;
};

/// The run was ended by what happened in it: too many failures in a row.
class RunError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A stage that has held a frame for longer than its limit.
struct HungStage {
  std::string stage;
  std::uint64_t frame = 0;  ///< its sequence number
  std::string message;      ///< one line
};

struct StageMetrics {
  Histogram wait;     ///< from ready to started
  Histogram service;  ///< from started to ended
  Histogram cpu;      ///< CPU time of one frame in 16
  std::atomic<std::uint64_t> failed{0};
  std::atomic<std::uint64_t> late{0};     ///< live: calls of its fallback, for frames over their latency budget
  std::atomic<std::uint64_t> skipped{0};  ///< background, live: frames that were not taken over, for want of memory
};

struct RunMetrics {
  Histogram end_to_end;  ///< from arrival to the end of delivery
  Histogram age;         ///< from the sensor to the end of delivery
  Histogram jitter;      ///< how much longer or shorter than between their captures it is between two deliveries
  Histogram in_flight;   ///< frames in the ring, at every admission: a count, no time
};

class Runtime {
 public:
  /// `bodies` holds one body for each node of the graph (the source's is not called). Throws std::invalid_argument.
  Runtime(Graph graph, std::vector<NodeBody> bodies, const PipelineOptions& options, Clock& clock);
  ~Runtime();

  int slots() const { return static_cast<int>(slots_.size()); }

  // --- the admission: one thread, between start() and finish()
  /// Makes the threads. What the system refuses them stands in refusals() then.
  void start();
  /// Whether wait_for_slot() would return at once.
  bool slot_is_free() const { return slots_[static_cast<std::size_t>(admitted_ % slots_.size())].free.load(); }
  /// Sleeps until the next slot in the ring is free; -1 when stopped.
  int wait_for_slot();
  /// Live: sleeps until a frame could start (true), or `deadline_ns` is reached or the run is stopped (false). A frame
  /// can start when a credit is free and a worker has nothing to do: until then it would only grow old inside, while
  /// outside a newer one may take its place.
  bool wait_for_start(std::int64_t deadline_ns);
  /// Live: whether there is a credit, at least.
  bool credit_is_free() const { return credits_taken() < options_.live_credits && !stopped(); }
  /// Sleeps until the clock reaches `time_ns`, or the run is stopped.
  void sleep_until(std::int64_t time_ns);
  /// Around the call that fills the slot: the watchdog looks at that, too, for no longer than `limit_ns` (0: never).
  void source_begins(std::int64_t limit_ns);
  void source_ends() { posts_[source_post()].leave(); }
  /// The slot that wait_for_slot() gave is filled. `failure`: it could not be, and why.
  void admit(FrameInfo info, const std::string* failure);
  void drop(DropReason reason, std::uint64_t count = 1);
  /// No frame will come any more: waits until all are delivered, joins the workers, rethrows what ended the run.
  void finish();

  /// Not while it runs. Called once, by the watchdog's thread, when a stage hangs and all earlier frames are delivered;
  /// no delivery comes any more. The hung call cannot be ended and finish() waits for it: who does not want to, ends
  /// the process from here. Should it ever come back, finish() throws a RunError with the message.
  void on_hang(std::function<void(const HungStage&)> callback) { tell_of_hang_ = std::move(callback); }
  /// Lines of what the system refused: pinning, SCHED_FIFO, locked memory. Complete when start() returns.
  const std::vector<std::string>& refusals() const { return refusals_; }
  // --- a stage, in its call
  /// turn(i) for every i in [0, n), by the caller and by workers that have nothing to do that is nearer to the
  /// delivery. Blocks until all are made.
  template <class Turn>
  void share(int n, const Turn& turn) {
    loops_.run(rank_of_caller(), n, turn, [this](int helpers) { work_there_.notify(helpers); });
  }

  // --- anybody, any time
  /// No more admissions; what is in flight comes out. Calls what on_stop() was given.
  void stop();
  /// Not while it runs. Called by whoever stops, perhaps several times and at once.
  void on_stop(std::function<void()> wake_source) { wake_source_ = std::move(wake_source); }
  bool stopped() const { return stopped_.load(); }
  Counts counts() const { return ledger_.snapshot(); }
  const StageMetrics& stage_metrics(std::size_t node) const { return *metrics_[node]; }
  const RunMetrics& run_metrics() const { return run_metrics_; }
  /// Empties the latencies: what was seen so far was the warm-up.
  void forget_latencies();
  const Graph& graph() const { return graph_; }
  Clock& clock() { return clock_; }

 private:
  enum class NodeOutcome : std::uint8_t { ok, failed, skipped };
  struct NodeState {
    std::atomic<int> pending{0};  ///< what it still waits for: producers, and, in order, itself with the frame before
    NodeOutcome outcome = NodeOutcome::ok;
    std::int64_t t_ready_ns = 0;
    std::string message;
  };
  struct Slot {
    FrameInfo info;
    std::atomic<bool> free{true};
    std::atomic<int> holds{0};  ///< the delivery, the background, and who will read this frame as its previous one
    std::vector<NodeState> nodes;
  };

  struct Background {
    Background(std::size_t n, int buffers, bool is_exact) : node(n), jobs(buffers), values(buffers, is_exact) {}
    std::size_t node;
    BackgroundJobs jobs;
    DelayedValues values;
    std::atomic<std::uint64_t> published{0};  ///< frames of which it made something, or is known to make nothing
    std::atomic<int> failures_row{0};
  };

  /// Replay: what is read is a function of the frame alone.
  bool exact() const { return options_.admission == Admission::every_frame; }
  void make_orders();
  void start_trace();
  void set_up_thread(int worker);
  int initial_pending(const Graph::Node& node) const;
  void work(int worker);
  bool help_or_take(int worker);
  std::optional<std::pair<std::size_t, int>> take(int worker, int below_rank);
  bool something_to_do(const std::vector<std::size_t>& nodes) const;
  bool could_start_a_frame() const;
  void sleep(int worker, ShortWait& patience);
  void wake_workers(int count);
  int rank_of_caller() const;
  bool is_long(std::size_t node) const { return usual_ns_[node].load(std::memory_order_relaxed) >= kLong_ns; }
  void begin_long();
  void took(std::size_t node, std::int64_t ns);
  void execute(std::size_t node, int slot, int worker);
  // --- these return when they ended
  std::int64_t run_body(std::size_t node, Slot& slot, const NodeCall& call);
  std::int64_t call_missed(std::size_t node, Slot& slot, const NodeCall& call);
  std::int64_t deliver(Slot& slot, const NodeCall& call);

  void fall_back(std::size_t node, const NodeCall& call);
  void write_down(std::size_t node, const NodeCall& call, TraceEvent::Kind kind, std::int64_t start_ns,
                  std::int64_t end_ns);
  void call_delivery(const NodeCall& call, std::int64_t now_ns);
  void record_delivery(const FrameInfo& info, std::int64_t now_ns);
  Outcome outcome_of(const Slot& slot) const;
  bool has_inputs(std::size_t node, const Slot& slot) const;
  /// Tells the dependents (and the next frame's turn); returns how many tokens became ready.
  int complete(std::size_t node, int slot, std::int64_t now_ns);
  int arrive(std::size_t node, int slot, std::int64_t now_ns);
  void release(int slot);
  void end_with(std::exception_ptr error);
  bool all_is_done() const;

  // --- watchdog.cpp
  struct Overdue {
    Post::Held held;
    std::size_t post = 0;
  };
  void watch();
  std::optional<Overdue> overdue(std::int64_t now_ns, std::int64_t& next_look_ns) const;
  void end_hung(const Overdue& hung);
  bool came_out(const Overdue& hung) const;
  HungStage describe(const Overdue& hung) const;

  // --- numbers of posts, and of the trace's rows
  std::size_t source_post() const { return 0; }
  static std::size_t worker_post(int worker) { return static_cast<std::size_t>(worker) + 1; }
  int relief() const { return options_.workers; }  ///< the worker who comes when one hangs
  std::size_t background_post() const { return worker_post(relief()) + 1; }
  std::size_t posts() const { return background_post() + 1; }

  // --- runtime_background.cpp; the counts are of tokens that became ready
  void make_background();
  Background& background(std::size_t node);
  void take_delayed(std::size_t node, NodeCall& call);
  void let_delayed_go(std::size_t node, const NodeCall& call);
  int take_over(std::size_t node, const Slot& slot, const NodeCall& call);
  int published(Background& b, std::uint64_t sequence);
  void failed_in_background(Background& b, const std::exception_ptr& error);
  void work_in_background();
  Background* oldest_job() const;
  void work_on(Background& b);

  int next(int slot) const { return slot + 1 == slots() ? 0 : slot + 1; }
  int before(int slot) const { return slot == 0 ? slots() - 1 : slot - 1; }
  int credits_taken() const { return static_cast<int>(admitted_ - delivered_.load()); }

  Graph graph_;
  std::vector<NodeBody> bodies_;
  std::function<void()> wake_source_;
  std::function<void(const HungStage&)> tell_of_hang_;
  PipelineOptions options_;
  Clock& clock_;
  std::vector<Slot> slots_;
  std::unique_ptr<ReadySet[]> ready_;
  std::vector<std::unique_ptr<StageMetrics>> metrics_;
  RunMetrics run_metrics_;
  std::vector<int> rank_;                         ///< of each node, the nearest to the delivery 0
  std::vector<std::vector<std::size_t>> orders_;  ///< of each worker (the relief, too): the nodes that it looks for
  const bool watched_;                            ///< by the watchdog or the trace
  OpenLoops loops_;
  std::unique_ptr<Post[]> posts_;
  std::atomic<std::int64_t> source_limit_ns_{0};
  std::int64_t source_began_ns_ = 0;  // the admission's own
  std::mutex refusals_mutex_;
  std::vector<std::string> refusals_;
  Ledger ledger_;
  int holders_ = 1;  ///< of a slot: see Slot::holds
  std::vector<std::unique_ptr<Background>> background_;
  std::vector<std::vector<std::uint64_t>> last_seen_;  ///< of each node's delayed values; live

  std::uint64_t admitted_ = 0;  // the admission's own
  ShortWait patience_;
  std::uint64_t dropped_since_ = 0;
  bool admission_is_fifo_ = false;
  std::uint64_t failures_row_ = 0;  // the delivery's own
  std::mutex error_mutex_;
  std::exception_ptr error_;
  std::int64_t last_delivery_ns_ = 0, last_sensor_ns_ = 0;  // the delivery's own
  std::mutex delivery_mutex_;
  bool delivery_closed_ = false;  ///< it threw, or a stage hangs: it is not called again

  /// What a node's calls take at most, lately. A call that usually takes less than waking somebody up does is over
  /// before another worker could be there for what waits behind it.
  std::unique_ptr<std::atomic<std::int64_t>[]> usual_ns_;
  static constexpr std::int64_t kLong_ns = 5'000;
  /// Workers that are awake and in no long call: they will look for tokens by themselves.
  alignas(64) std::atomic<int> at_hand_{0};
  alignas(64) std::atomic<std::uint64_t> delivered_{0};
  static constexpr int kNoSlot = -1;
  std::atomic<int> wanted_slot_{kNoSlot};  ///< that the admission sleeps for
  std::atomic<bool> stopped_{false};
  std::atomic<bool> closed_{false};
  EventCount work_there_;
  EventCount room_there_;  ///< for the admission: the slot that it wants; live: a credit
  EventCount done_there_;  ///< for finish()
  EventCount background_there_;
  EventCount watchdog_;                ///< only the end wakes it up
  EventCount drained_;                 ///< a delivery, for the watchdog
  std::vector<std::jthread> workers_;  // last: they use all of the above
};

}  // namespace pavo
