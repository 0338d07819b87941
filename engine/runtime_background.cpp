// The part of the runtime that frames do not wait for.
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include "engine/runtime.h"

namespace pavo {

void Runtime::make_background() {
  for (std::size_t n = 0; n < graph_.nodes.size(); ++n)
    if (graph_.nodes[n].kind == StageKind::background)
      background_.push_back(std::make_unique<Background>(n, graph_.buffers, exact()));
}

Runtime::Background& Runtime::background(std::size_t node) {
  return **std::find_if(background_.begin(), background_.end(), [&](const auto& b) { return b->node == node; });
}

void Runtime::take_delayed(std::size_t node, NodeCall& call) {
  const auto& edges = graph_.nodes[node].delayed;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    // Live, two parts of one writer are of one frame: the newest is looked for once.
    const auto same = std::find_if(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(i),
                                   [&](const Graph::DelayedEdge& e) { return e.writer == edges[i].writer; });
    const auto first = static_cast<std::size_t>(same - edges.begin());
    call.delayed_buffer[i] =
        !exact() && first < i
            ? call.delayed_buffer[first]
            : background(edges[i].writer).values.take(call.info.sequence, edges[i].delay, last_seen_[node][i]);
  }
}

void Runtime::let_delayed_go(std::size_t node, const NodeCall& call) {
  const auto& edges = graph_.nodes[node].delayed;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool shared = std::any_of(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(i),
                                    [&](const Graph::DelayedEdge& e) { return e.writer == edges[i].writer; });
    if (!shared) background(edges[i].writer).values.let_go(call.delayed_buffer[i]);
  }
}

int Runtime::take_over(std::size_t node, const Slot& slot, const NodeCall& call) {
  Background& b = background(node);
  StageMetrics& metrics = *metrics_[node];
  bool taken = false;
  if (has_inputs(node, slot)) {
    const int work = b.jobs.room();  // every frame: there always is, since the frame waited for it
    Post& post = posts_[worker_post(call.worker)];
    if (watched_) post.enter(node, call.info.sequence, clock_.now_ns());
    try {
      if (work >= 0)
        taken = bodies_[node].take(call, work);
      else
        metrics.skipped.fetch_add(1, std::memory_order_relaxed);
    } catch (...) {
      failed_in_background(b, std::current_exception());
    }
    post.leave();
  }
  if (!taken) return published(b, call.info.sequence);
  b.jobs.put(call.info, clock_.now_ns());
  background_there_.notify_one();
  return 0;
}

int Runtime::published(Background& b, std::uint64_t sequence) {
  int ready = 0;
  if (exact()) {
    const std::int64_t now = clock_.now_ns();
    const auto slot_of = [&](std::uint64_t s) { return static_cast<int>(s % slots_.size()); };
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n)
      for (const Graph::DelayedEdge& edge : graph_.nodes[n].delayed)
        if (edge.writer == b.node) ready += arrive(n, slot_of(sequence + static_cast<std::uint64_t>(edge.delay)), now);
    ready += arrive(b.node, slot_of(sequence + static_cast<std::uint64_t>(graph_.buffers)), now);
  }
  b.published.fetch_add(1);
  done_there_.notify_one();
  drained_.notify_one();
  return ready;
}

void Runtime::failed_in_background(Background& b, const std::exception_ptr& error) {
  metrics_[b.node]->failed.fetch_add(1, std::memory_order_relaxed);
  if (b.failures_row.fetch_add(1) + 1 != options_.failures_in_a_row) return;
  std::string message = "threw something that is no std::exception";
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& e) {
    message = e.what();
  } catch (...) {
  }
  end_with(std::make_exception_ptr(RunError(std::to_string(options_.failures_in_a_row) + " frames failed in a row in " +
                                            graph_.nodes[b.node].name + ": " + message)));
}

void Runtime::work_in_background() {
  pthread_setname_np(pthread_self(), "pavo-background");
  // Live, a frame's stages come first. A thread's own nice value: refused by no system, since it only goes up.
  if (!exact()) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), options_.background_nice);
  while (!closed_.load()) {
    Background* b = oldest_job();
    if (!b) {
      const EventCount::Key key = background_there_.prepare();
      b = oldest_job();
      if (!b && !closed_.load()) {
        background_there_.wait(key);
        continue;
      }
      background_there_.cancel();
    }
    if (b) work_on(*b);
  }
}

Runtime::Background* Runtime::oldest_job() const {
  Background* oldest = nullptr;
  for (const auto& b : background_)
    if (const auto* job = b->jobs.front())
      if (!oldest || job->info.sequence < oldest->jobs.front()->info.sequence) oldest = b.get();
  return oldest;
}

void Runtime::work_on(Background& b) {
  const BackgroundJobs::Job& job = *b.jobs.front();
  const std::uint64_t sequence = job.info.sequence;
  StageMetrics& metrics = *metrics_[b.node];
  if (options_.disturb) options_.disturb(b.node, sequence);
  const int buffer = b.values.to_write(sequence);
  const std::int64_t start = clock_.now_ns(), cpu_start = thread_cpu_ns();
  Post& post = posts_[background_post()];
  post.enter(b.node, sequence, start);
  TraceEvent::Kind kind = TraceEvent::Kind::stage;
  try {
    if (bodies_[b.node].work(job.info, job.work, buffer)) b.values.publish(buffer, sequence);
    b.failures_row.store(0);
  } catch (...) {
    kind = TraceEvent::Kind::failed;
    failed_in_background(b, std::current_exception());
  }
  post.leave();
  const std::int64_t end = clock_.now_ns();
  metrics.cpu.record(thread_cpu_ns() - cpu_start);
  metrics.wait.record(start - job.t_ready_ns);
  metrics.service.record(end - start);
  if (options_.trace)
    options_.trace->record(static_cast<int>(background_post()), {.t_start_ns = start,
                                                                 .t_end_ns = end,
                                                                 .wait_ns = start - job.t_ready_ns,
                                                                 .sequence = sequence,
                                                                 .node = static_cast<std::uint32_t>(b.node),
                                                                 .kind = kind});
  b.jobs.pop();
  wake_workers(published(b, sequence));
}

}  // namespace pavo
