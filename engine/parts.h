// How a stage names what it reads and writes.
#pragma once

#include <string>
#include <tuple>
#include <typeinfo>

#include "engine/graph.h"  // before the words below: else g++ says that its enumerators shadow them

namespace pavo {

/// A part of the frame that a background stage writes. The member of this type only names it: the values are the
/// engine's, in a ring of their own, so that a frame need not wait for them. Read it with delayed<>().
template <class T>
struct Delayed {
  using Value = T;
};

template <class Frame, class T>
struct Previous {
  T Frame::*member;
};
/// The part of the frame before: nullptr where there is none. For in-order stages, which must read the current one,
/// too.
template <class Frame, class T>
Previous<Frame, T> previous(T Frame::*member) {
  return {member};
}

template <class Frame, class T>
struct DelayedRead {
  Delayed<T> Frame::*member;
  int delay;
};
/// What a background stage made of the frame `delay` before this one: nullptr where it made nothing of it. For in-order
/// stages that the background stage (through others) reads from. Each value is given once.
///   every frame: exactly that frame's; this one waits until it is there;
///   live: the newest that is there and was not given yet, whatever its frame; nobody waits.
template <int delay, class Frame, class T>
DelayedRead<Frame, T> delayed(Delayed<T> Frame::*member) {
  static_assert(delay >= 1, "a value flows back to a later frame");
  return {member, delay};
}

template <class... Parts>
struct Reads {
  std::tuple<Parts...> parts;
};
template <class... Parts>
Reads<Parts...> reads(Parts... parts) {
  return {{parts...}};
}

template <class... Parts>
struct Writes {
  std::tuple<Parts...> parts;
};
template <class... Parts>
Writes<Parts...> writes(Parts... parts) {
  return {{parts...}};
}

struct Parallel {};
struct InOrder {};
struct InBackground {};
inline constexpr Parallel parallel{};
inline constexpr InOrder in_order{};
inline constexpr InBackground background{};

/// "pavo::Features" rather than the mangled name; for messages.
std::string demangled(const std::type_info& type);

}  // namespace pavo
