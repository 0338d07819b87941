// From a stage, and the parts that it reads and writes, to what the runtime calls.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/node.h"
#include "engine/parts.h"

namespace pavo::detail {

template <class T>
concept HasScratch = requires {
  typename T::Scratch;
};

/// It has a fallback for frames over their latency budget (one: it must not be overloaded).
template <class T>
concept HasLate = requires {
  &T::late;
};

template <class T>
struct ScratchOf {
  using type = std::tuple<>;
};
template <HasScratch T>
struct ScratchOf<T> {
  using type = typename T::Scratch;
};

template <class T>
inline constexpr bool kIsDelayed = false;
template <class T>
inline constexpr bool kIsDelayed<Delayed<T>> = true;
template <class Frame, class T>
constexpr bool is_delayed(T Frame::*) {
  return kIsDelayed<T>;
}

template <class Callee, class Tuple>
inline constexpr bool kCallableWith = false;
template <class Callee, class... A>
inline constexpr bool kCallableWith<Callee, std::tuple<A...>> = std::is_invocable_v<Callee&, A...>;

/// With the frame's info first where the stage takes it, else without.
template <class Callee, class Arguments>
decltype(auto) call_stage(Callee& callee, const FrameInfo& info, const Arguments& arguments) {
  const auto with_info = std::tuple_cat(std::tuple<const FrameInfo&>(info), arguments);
  if constexpr (kCallableWith<Callee, std::remove_const_t<decltype(with_info)>>)
    return std::apply(callee, with_info);
  else
    return std::apply(callee, arguments);
}

/// The buffers of all delayed values, by the offset of the member that names them.
class DelayedMemory {
 public:
  template <class T>
  std::vector<T>* of(std::size_t offset) {
    for (const Entry& e : entries_)
      if (e.offset == offset) return static_cast<std::vector<T>*>(e.values.get());
    auto values = std::make_shared<std::vector<T>>();
    entries_.push_back(
        {offset, values, [v = values.get()](int n) { *v = std::vector<T>(static_cast<std::size_t>(n)); }});
    return values.get();
  }
  void make(int buffers) {
    for (const Entry& e : entries_) e.make(buffers);
  }

 private:
  struct Entry {
    std::size_t offset;
    std::shared_ptr<void> values;
    std::function<void(int)> make;
  };
  std::vector<Entry> entries_;
};

// --- a part, bound to where it is found

template <class Frame, class T>
struct Current {
  T Frame::*member;
  const T& get(const std::vector<Frame>& frames, const NodeCall& call, int&, int&) const {
    return frames[static_cast<std::size_t>(call.slot)].*member;
  }
};
template <class Frame, class T>
struct Before {
  T Frame::*member;
  const T* get(const std::vector<Frame>& frames, const NodeCall& call, int& index, int&) const {
    const bool there = call.previous_slot >= 0 && (call.previous_ok >> index & 1);
    ++index;
    return there ? &(frames[static_cast<std::size_t>(call.previous_slot)].*member) : nullptr;
  }
};
template <class Frame, class T>
struct Earlier {
  std::vector<T>* values;
  const T* get(const std::vector<Frame>&, const NodeCall& call, int&, int& index) const {
    const int buffer = call.delayed_buffer[static_cast<std::size_t>(index++)];
    return buffer < 0 ? nullptr : &(*values)[static_cast<std::size_t>(buffer)];
  }
};

// What a stage is given of a frame that failed: all that is of other frames.
template <class Frame, class T>
std::tuple<> of_other_frames(Current<Frame, T>) {
  return {};
}
template <class Part>
std::tuple<Part> of_other_frames(Part part) {
  return {part};
}

template <class Frame, class Parts>
auto inputs(const std::vector<Frame>& frames, const NodeCall& call, const Parts& parts) {
  int before = 0, earlier = 0;  // count the parts of either kind, for their place in the call
  // The braces fix the order of evaluation, from left to right.
  return std::apply(
      [&](const auto&... part) {
        return std::tuple<decltype(part.get(frames, call, before, earlier))...>{
            part.get(frames, call, before, earlier)...};
      },
      parts);
}

template <class Frame, class Parts>
auto outputs(std::vector<Frame>& frames, const NodeCall& call, const Parts& parts) {
  return std::apply([&](auto... m) { return std::tie(frames[static_cast<std::size_t>(call.slot)].*m...); }, parts);
}

/// `frames`: the ring. `in`: a tuple of Current, Before and Earlier; `out`: one of members of Frame.
template <bool is_parallel, class Frame, class In, class Out, class Stage>
NodeBody stage_body(std::vector<Frame>& frames, const In& in, const Out& out, Stage stage, int workers) {
  using Object = std::remove_reference_t<std::unwrap_reference_t<Stage>>;
  using Callee = std::conditional_t<is_parallel, const Object, Object>;
  using Scratch = typename ScratchOf<std::remove_cv_t<Object>>::type;
  constexpr bool has_scratch = HasScratch<std::remove_cv_t<Object>>;
  struct State {
    Stage stage;
    std::deque<Scratch> scratch;  // one a worker; a deque, since a scratch need not be movable
  };
  auto state = std::make_shared<State>(State{std::move(stage), {}});
  if constexpr (has_scratch) state->scratch.resize(static_cast<std::size_t>(workers) + 1);  // and the relief

  NodeBody body;
  body.run = [&frames, state, in, out](const NodeCall& call) {
    Callee& callee = state->stage;
    const auto arguments = std::tuple_cat(inputs(frames, call, in), outputs(frames, call, out));
    if constexpr (has_scratch) {
      Scratch& scratch = state->scratch[static_cast<std::size_t>(call.worker)];
      call_stage(callee, call.info, std::tuple_cat(arguments, std::tuple<Scratch&>(scratch)));
    } else {
      call_stage(callee, call.info, arguments);
    }
  };
  if constexpr (HasLate<std::remove_cv_t<Object>>)
    body.late = [&frames, state, in, out](const NodeCall& call) {
      Callee& callee = state->stage;
      const auto late = [&](auto&&... a) -> decltype(callee.late(a...)) { return callee.late(a...); };
      call_stage(late, call.info, std::tuple_cat(inputs(frames, call, in), outputs(frames, call, out)));
    };
  if constexpr (!is_parallel) {
    const auto others = std::apply([](auto... part) { return std::tuple_cat(of_other_frames(part)...); }, in);
    body.missed = [&frames, state, others, out](const NodeCall& call) {
      Object& callee = state->stage;
      const auto missed = [&](auto&&... a) -> decltype(callee.missed(a...)) { return callee.missed(a...); };
      call_stage(missed, call.info, std::tuple_cat(inputs(frames, call, others), outputs(frames, call, out)));
    };
  }
  return body;
}

/// `out`: a tuple of pointers to the buffers of delayed values. `make_memory(n)` comes before the first frame.
template <class Frame, class In, class Out, class Stage>
NodeBody background_body(std::vector<Frame>& frames, const In& in, const Out& out, Stage stage,
                         std::function<void(int)>& make_memory) {
  using Object = std::remove_reference_t<std::unwrap_reference_t<Stage>>;
  using Work = typename std::remove_cv_t<Object>::Work;
  struct State {
    Stage stage;
    std::vector<Work> works;
  };
  auto state = std::make_shared<State>(State{std::move(stage), {}});
  make_memory = [state](int n) { state->works = std::vector<Work>(static_cast<std::size_t>(n)); };

  NodeBody body;
  body.take = [&frames, state, in](const NodeCall& call, int work) -> bool {
    const Object& callee = state->stage;  // it is at work on an earlier frame, perhaps
    const auto take = [&](auto&&... a) -> decltype(callee.take(a...)) { return callee.take(a...); };
    const auto memory = std::tuple<Work&>(state->works[static_cast<std::size_t>(work)]);
    return call_stage(take, call.info, std::tuple_cat(inputs(frames, call, in), memory));
  };
  body.work = [state, out](const FrameInfo& info, int work, int buffer) -> bool {
    Object& callee = state->stage;
    const auto values =
        std::apply([&](auto*... v) { return std::tie((*v)[static_cast<std::size_t>(buffer)]...); }, out);
    const auto memory = std::tuple<Work&>(state->works[static_cast<std::size_t>(work)]);
    const auto arguments = std::tuple_cat(memory, values);
    if constexpr (std::is_void_v<decltype(call_stage(callee, info, arguments))>) {
      call_stage(callee, info, arguments);
      return true;
    } else {
      return call_stage(callee, info, arguments);
    }
  };
  return body;
}

}  // namespace pavo::detail
