// A staged dataflow over frames: stages say what they read and write, the engine does the rest.
//
//     Pipeline<Frame> pipeline(options, clock);
//     pipeline.source(writes(&Frame::raw));
//     pipeline.add("features", reads(&Frame::raw), writes(&Frame::features), features, parallel);
//     pipeline.add("odometry", reads(&Frame::features, previous(&Frame::features), delayed<2>(&Frame::map)),
//                  writes(&Frame::pose), std::ref(odometry), in_order);
//     pipeline.add("map", reads(&Frame::features, &Frame::pose), writes(&Frame::map), std::ref(map), background);
//     pipeline.deliver([](const Frame& frame, const FrameInfo& info, const Outcome& outcome) { ... });
//     pipeline.run(source);
//
// A stage is called as  stage([info,] inputs..., outputs...[, scratch]):
//   inputs   `const T&` for each part that it reads, `const T*` for each previous(): null where the frame before is not
//            there or failed before that part was written; and `const T*` for each delayed(): null where there is none;
//   outputs  `T&`, holding whatever an earlier frame in this slot left there: write all, and reuse the memory;
//   info     `const FrameInfo&`, for a stage that can be called with it first;
//   scratch  `Stage::Scratch&`, where the stage has such a type: one for each worker, made before the first frame.
// A parallel stage is called through a const reference, by several workers at once. An in-order stage sees every frame
// once, in order; for a frame that failed before it, `stage.missed([info,] previous and delayed..., outputs...)` is
// called instead, so that its outputs hold something sensible and it can carry on. Stages may throw: that fails the
// frame, not the run.
//
// A background stage is what a frame does not wait for, such as a map that is refined behind its back. In the frame,
// the member of what it writes is a name only (`Delayed<MapUpdate> map;`): the values are the engine's. It has a type
// Work, and is called twice for a frame:
//   bool take([info,] inputs..., Work&) const   by a worker, in order, once for every frame that did not fail: copies
//            what it needs; false: it needs nothing of this frame ("nothing for k" is published at once). The frame is
//            let go then. It may run while the other call is busy with an earlier frame, and must not read what that
//            changes.
//   [bool] operator()([info,] Work&, outputs...)   by a thread of its own, for one frame at a time, in order. Outputs
//            hold what an earlier frame left there. false: nothing for this frame. A throw is counted, and publishes
//            nothing. Live this thread is a nice one, and where it falls behind by more than it has Work for, frames
//            are not even taken (counted as skipped); no frame is ever late because of it. Where every frame counts,
//            the readers wait for it as their delay says, and all is the same on every run, with any number of workers.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "engine/runtime.h"
#include "engine/stage_body.h"

namespace pavo {

/// Where frames come from. Called by the thread that runs the pipeline.
template <class Frame>
class Source {
 public:
  virtual ~Source() = default;
  /// Fills in the next frame's parts and info (source_index, t_capture_ns; t_arrival_ns and t_sensor_ns if it knows
  /// better than "now"; gap: what the driver lost); false at the end. Throws where this one frame cannot be had: it is
  /// admitted as failed, and the next call goes on behind it. May block.
  virtual bool read(FrameInfo& info, Frame& frame) = 0;
  /// Live: when (engine clock) the next frame will be there; nothing at the end. It may lie in the past.
  virtual std::optional<std::int64_t> next_arrival_ns() = 0;
  /// Live: a device that holds its newest frame for whoever comes. It is not asked for the next arrival, but read when
  /// there is room for a frame: read() waits for one, and says how many went by unread (info.stale).
  virtual bool holds_newest() const { return false; }
  /// The same at the end of the run: it stops, and tells how many frames went by unread since the last one that was
  /// read.
  virtual std::uint64_t unread() { return 0; }
  /// The run was stopped, by whatever thread calls this: a read() that waits, or comes now, returns false soon.
  virtual void interrupt() {}
};

/// Frame: any default-constructible type; its parts are its members. Declare first, then run() once; not copyable.
/// stop() and counts() may be called by any thread while it runs.
template <class Frame>
class Pipeline {
 public:
  Pipeline(const PipelineOptions& options, Clock& clock) : options_(options), clock_(clock) {}

  template <class... Parts>
  void source(Writes<Parts...> out) {
    std::apply([&](auto... m) { (source_writes_.push_back(part(m)), ...); }, out.parts);
  }

  template <class... In, class... Out, class Stage, class Kind>
  void add(const std::string& name, Reads<In...> in, Writes<Out...> out, Stage stage, Kind) {
    constexpr bool in_background = std::is_same_v<Kind, InBackground>;
    static_assert(std::is_same_v<Kind, Parallel> || std::is_same_v<Kind, InOrder> || in_background,
                  "a stage is `parallel`, `in_order` or `background`");
    static_assert((... && (detail::is_delayed(Out()) == in_background)),
                  "background stages, and only they, write parts of type Delayed<T>");
    StageDeclaration declaration{.name = name, .kind = kind_of(Kind())};
    std::apply([&](auto... m) { (declare_read(declaration, m), ...); }, in.parts);
    std::apply([&](auto... m) { (declaration.writes.push_back(part(m)), ...); }, out.parts);
    declarations_.push_back(std::move(declaration));
    bodies_.push_back(make_body<Kind>(in, out, std::move(stage)));
  }

  /// Called once for every admitted frame, in order, by a worker, when all stages are through with it. A throw ends
  /// the run with that exception: for what makes going on pointless, such as a full disk.
  void deliver(std::function<void(const Frame&, const FrameInfo&, const Outcome&)> callback) {
    deliver_ = std::move(callback);
  }

  /// Every call is written down there, which must outlive the run; before prepare().
  void trace_to(Trace& trace) { options_.trace = &trace; }

  /// Called before every call of a stage, by its thread; for tests that disturb the timing. Before prepare().
  void disturb_with(std::function<void(std::size_t node, std::uint64_t sequence)> disturb) {
    options_.disturb = std::move(disturb);
  }

  /// Checks the graph and makes the ring: GraphError and std::invalid_argument come from here.
  void prepare() {
    Graph graph = derive_graph(source_writes_, declarations_);
    std::vector<NodeBody> bodies(1);  // the source's is not called
    for (auto& body : bodies_) bodies.push_back(body);
    bodies.push_back({.run = [this](const NodeCall& call) {
      if (deliver_) deliver_(frames_[call.slot], call.info, *call.outcome);
    }});
    runtime_ = std::make_unique<Runtime>(std::move(graph), std::move(bodies), options_, clock_);
    runtime_->on_stop([this] { interrupt_source(); });
    frames_ = std::vector<Frame>(static_cast<std::size_t>(runtime_->slots()));
    delayed_.make(runtime_->graph().buffers);
    for (const auto& make : make_memory_) make(runtime_->graph().buffers);
  }

  /// Runs until the source ends or stop() is called, and all that was admitted is delivered. Blocks. Throws what
  /// prepare() throws, what the delivery threw, and RunError.
  void run(Source<Frame>& source) {
    if (!runtime_) prepare();
    const Interruptible while_it_runs(*this, source);
    start();
    if (options_.admission != Admission::live)
      admit_all(source);
    else if (source.holds_newest())
      admit_held(source);
    else
      admit_newest(source);
    finish();
  }

  // --- the same in pieces, for a caller who pushes: start(), admit() as often as frames come, finish()
  void start() {
    if (!runtime_) prepare();
    runtime_->start();
  }
  /// Waits for room, lets `fill(info, frame)` write the source's parts, and sends the frame off. False when stopped.
  /// Live: returns false at once when there is no credit or no slot; the frame is counted as dropped.
  template <class Fill>
  bool admit(Fill&& fill) {
    if (options_.admission == Admission::live && !(runtime_->credit_is_free() && runtime_->slot_is_free())) {
      runtime_->drop(runtime_->stopped() ? DropReason::stopped : DropReason::replaced);
      return false;
    }
    const int slot = runtime_->wait_for_slot();
    if (slot < 0) return false;
    FrameInfo info{.t_arrival_ns = clock_.now_ns()};
    fill(info, frames_[slot]);
    runtime_->admit(info, nullptr);
    return true;
  }
  void finish() { runtime_->finish(); }

  /// See Runtime. From prepare() on, before it runs.
  void on_hang(std::function<void(const HungStage&)> callback) { runtime_->on_hang(std::move(callback)); }

  /// For a stage, in its call: turn(i) for every i in [0, n), by its worker and those that have nothing else to do.
  template <class Turn>
  void share(int n, const Turn& turn) {
    runtime_->share(n, turn);
  }

  /// No more admissions; what is in flight comes out. Valid from prepare() on.
  void stop() { runtime_->stop(); }
  Counts counts() const { return runtime_->counts(); }
  /// Any thread; see Runtime.
  void forget_latencies() { runtime_->forget_latencies(); }
  /// The nodes' names and metrics; valid from prepare() to the end of the pipeline's life.
  const Runtime& runtime() const { return *runtime_; }

 private:
  template <class T>
  Part part(T Frame::*member) const {
    const auto* base = reinterpret_cast<const char*>(&prototype_);
    const auto* at = reinterpret_cast<const char*>(&(prototype_.*member));
    return {.offset = static_cast<std::size_t>(at - base), .type = demangled(typeid(T))};
  }

  template <class T>
  void declare_read(StageDeclaration& declaration, T Frame::*member) const {
    declaration.reads.push_back(part(member));
  }
  template <class T>
  void declare_read(StageDeclaration& declaration, Previous<Frame, T> p) const {
    declaration.previous.push_back(part(p.member));
  }

  template <class T>
  void declare_read(StageDeclaration& declaration, DelayedRead<Frame, T> d) const {
    declaration.delayed.push_back({part(d.member), d.delay});
  }
  static constexpr StageKind kind_of(Parallel) { return StageKind::parallel; }
  static constexpr StageKind kind_of(InOrder) { return StageKind::in_order; }
  static constexpr StageKind kind_of(InBackground) { return StageKind::background; }

  // --- from the part that a stage names to where it is found
  template <class T>
  auto bound(T Frame::*member) {
    static_assert(!detail::kIsDelayed<T>, "a background stage's part is there only later: read it with delayed<>()");
    return detail::Current<Frame, T>{member};
  }
  template <class T>
  auto bound(Previous<Frame, T> p) {
    return detail::Before<Frame, T>{p.member};
  }
  template <class T>
  auto bound(DelayedRead<Frame, T> d) {
    return detail::Earlier<Frame, T>{delayed_.of<T>(part(d.member).offset)};
  }
  template <class... M>
  auto bound_all(const std::tuple<M...>& members) {
    return std::apply([&](auto... m) { return std::tuple<decltype(bound(m))...>{bound(m)...}; }, members);
  }

  template <class Kind, class... In, class... Out, class Stage>
  NodeBody make_body(const Reads<In...>& in, const Writes<Out...>& out, Stage stage) {
    const auto from = bound_all(in.parts);
    if constexpr (std::is_same_v<Kind, InBackground>) {
      const auto to = std::apply([&](auto... m) { return std::tuple{buffers_of(m)...}; }, out.parts);
      return detail::background_body(frames_, from, to, std::move(stage), make_memory_.emplace_back());
    } else {
      return detail::stage_body<std::is_same_v<Kind, Parallel>>(frames_, from, out.parts, std::move(stage),
                                                                options_.workers);
    }
  }
  template <class T>
  std::vector<T>* buffers_of(Delayed<T> Frame::*member) {
    return delayed_.of<T>(part(member).offset);
  }

  // Whoever stops the run, the source that it waits for hears of it.
  struct Interruptible {
    Interruptible(Pipeline& p, Source<Frame>& source) : pipeline(p) { set(&source); }
    ~Interruptible() { set(nullptr); }
    Interruptible(const Interruptible&) = delete;
    Interruptible& operator=(const Interruptible&) = delete;
    void set(Source<Frame>* source) {
      const std::lock_guard lock(pipeline.source_mutex_);
      pipeline.source_ = source;
    }
    Pipeline& pipeline;
  };
  void interrupt_source() {
    const std::lock_guard lock(source_mutex_);
    if (source_) source_->interrupt();
  }

  void admit_all(Source<Frame>& source) {
    for (int slot; (slot = runtime_->wait_for_slot()) >= 0;)
      if (!read_and_admit(source, slot)) return;
  }

  // A frame that has arrived is read into the next slot and waits there until it can start; when the next one arrives
  // first, it takes its place.
  void admit_newest(Source<Frame>& source) {
    while (!runtime_->stopped()) {
      const int slot = runtime_->wait_for_slot();
      std::optional<std::int64_t> arrival = source.next_arrival_ns();
      if (slot < 0 || !arrival) return;
      runtime_->sleep_until(*arrival);
      if (runtime_->stopped() || !read_newest(source, slot)) return;
    }
  }

  // The device keeps the newest frame until there is room for it.
  void admit_held(Source<Frame>& source) {
    for (int slot; (slot = runtime_->wait_for_slot()) >= 0;)
      if (!runtime_->wait_for_start(kNoEnd) || !read_and_admit(source, slot)) break;
    if (const std::uint64_t unread = source.unread(); unread > 0) runtime_->drop(DropReason::stopped, unread);
  }

  bool read_newest(Source<Frame>& source, int slot) {
    for (;;) {
      FrameInfo info;
      std::string failure;
      if (!read(source, slot, info, failure)) return false;
      const std::optional<std::int64_t> newer = source.next_arrival_ns();
      const bool outdated = newer && clock_.now_ns() >= *newer;
      if (!outdated && runtime_->wait_for_start(newer.value_or(kNoEnd))) {
        runtime_->admit(info, failure.empty() ? nullptr : &failure);
        return true;
      }
      runtime_->drop(runtime_->stopped() ? DropReason::stopped : DropReason::replaced);
      if (runtime_->stopped()) return false;
    }
  }

  bool read_and_admit(Source<Frame>& source, int slot) {
    FrameInfo info;
    std::string failure;
    if (!read(source, slot, info, failure)) return false;
    if (info.stale > 0) runtime_->drop(DropReason::stale, info.stale);
    runtime_->admit(info, failure.empty() ? nullptr : &failure);
    return true;
  }

  bool read(Source<Frame>& source, int slot, FrameInfo& info, std::string& failure) {
    runtime_->source_begins(source.holds_newest() ? 0 : options_.source_limit_ns);
    try {
      const bool there = source.read(info, frames_[static_cast<std::size_t>(slot)]);
      runtime_->source_ends();
      if (info.t_arrival_ns == 0) info.t_arrival_ns = clock_.now_ns();
      return there;
    } catch (const std::exception& e) {
      failure = *e.what() ? e.what() : "the frame could not be read";
      runtime_->source_ends();
    }
    if (info.t_arrival_ns == 0) info.t_arrival_ns = clock_.now_ns();
    return true;
  }

  static constexpr std::int64_t kNoEnd = std::numeric_limits<std::int64_t>::max();

  PipelineOptions options_;
  Clock& clock_;
  Frame prototype_{};
  std::vector<Part> source_writes_;
  std::vector<StageDeclaration> declarations_;
  std::vector<NodeBody> bodies_;
  std::function<void(const Frame&, const FrameInfo&, const Outcome&)> deliver_;
  std::vector<Frame> frames_;
  detail::DelayedMemory delayed_;
  std::deque<std::function<void(int)>> make_memory_;  // of the background stages
  std::mutex source_mutex_;
  Source<Frame>* source_ = nullptr;   // while it is read
  std::unique_ptr<Runtime> runtime_;  // last: its workers use all of the above
};

}  // namespace pavo
