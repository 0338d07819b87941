// The part of the runtime that notices a stage that hangs.
#include <pthread.h>

#include <algorithm>

#include "engine/runtime.h"

namespace pavo {
namespace {

std::string seconds(std::int64_t ns) {
  std::string text = std::to_string(ns / 1'000'000'000);
  if (const std::int64_t ms = ns / 1'000'000 % 1000; ms != 0) text += "." + std::to_string(1000 + ms).substr(1);
  return text + " s";
}

}  // namespace

// No polling: whatever begins from now on is not overdue before its limit has passed.
void Runtime::watch() {
  pthread_setname_np(pthread_self(), "pavo-watchdog");
  while (!closed_.load()) {
    std::int64_t next_look = 0;
    if (const auto hung = overdue(clock_.now_ns(), next_look)) return end_hung(*hung);
    const EventCount::Key key = watchdog_.prepare();
    if (closed_.load())
      watchdog_.cancel();
    else
      clock_.wait(watchdog_, key, next_look);
  }
}

std::optional<Runtime::Overdue> Runtime::overdue(std::int64_t now_ns, std::int64_t& next_look_ns) const {
  std::optional<Overdue> oldest;
  next_look_ns = INT64_MAX;
  for (std::size_t p = 0; p < posts(); ++p) {
    const std::int64_t limit = p == source_post() ? source_limit_ns_.load() : options_.stage_limit_ns;
    const std::int64_t earliest =
        p == source_post() ? std::max(options_.source_limit_ns, std::int64_t{1}) : options_.stage_limit_ns;
    if (p != source_post() && limit == 0) continue;
    if (p == source_post() && options_.source_limit_ns == 0) continue;
    const std::optional<Post::Held> held = posts_[p].held();
    const bool limited = held && limit > 0;
    next_look_ns = std::min(next_look_ns, limited ? held->since_ns + limit : now_ns + earliest);
    if (limited && now_ns >= held->since_ns + limit && (!oldest || held->sequence < oldest->held.sequence))
      oldest = Overdue{*held, p};
  }
  return oldest;
}

HungStage Runtime::describe(const Overdue& hung) const {
  const bool source = hung.post == source_post();
  const std::string& stage = graph_.nodes[hung.held.node].name;
  const std::string frame = std::to_string(hung.held.sequence);
  const std::string limit = seconds(source ? source_limit_ns_.load() : options_.stage_limit_ns);
  return {.stage = stage,
          .frame = hung.held.sequence,
          .message = source
                         ? "the source has not delivered frame " + frame + " within " + limit + ": it hangs"
                         : "stage '" + stage + "' has held frame " + frame + " for more than " + limit + ": it hangs"};
}

bool Runtime::came_out(const Overdue& hung) const {
  if (hung.post == source_post()) return ledger_.snapshot().in_flight == 0;
  return delivered_.load() >= hung.held.sequence + (hung.post == background_post() ? 1 : 0);
}

void Runtime::end_hung(const Overdue& hung) {
  stop();
  // The hung one may be the only worker; whoever is before it still has a way to go. Should that hang, too, there is an
  // end to waiting for it.
  const std::jthread relief_worker([this] {
    pthread_setname_np(pthread_self(), "pavo-relief");
    work(relief());
  });
  const std::int64_t patience_end =
      clock_.now_ns() + std::max<std::int64_t>({options_.stage_limit_ns, options_.source_limit_ns, 1});
  while (!closed_.load() && !came_out(hung) && clock_.now_ns() < patience_end) {
    const EventCount::Key key = drained_.prepare();
    if (closed_.load() || came_out(hung))
      drained_.cancel();
    else
      clock_.wait(drained_, key, patience_end);
  }
  const HungStage told = describe(hung);
  end_with(std::make_exception_ptr(RunError(told.message)));
  if (closed_.load()) return;  // it came back, and the run, which was ended for it, says why it is short
  // Should it come back now, nothing more is delivered while the end is told.
  std::unique_lock lock(delivery_mutex_, std::defer_lock);
  if (hung.held.node != graph_.delivery()) {
    lock.lock();
    delivery_closed_ = true;
  }
  if (tell_of_hang_) tell_of_hang_(told);
}

}  // namespace pavo
