// Replaces operator new for a whole test program by one that counts. Include it in one file of the program only.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

namespace pavo::test {

/// Every call of an operator new so far, by any thread.
inline std::atomic<long> allocations{0};

/// Called for each allocation, by the thread that makes it; a test may count only some.
inline std::atomic<bool (*)()> counts_here{nullptr};

inline void count() noexcept {
  bool (*const counts)() = counts_here.load(std::memory_order_relaxed);
  if (counts == nullptr || counts()) allocations.fetch_add(1, std::memory_order_relaxed);
}

inline void* counted(std::size_t size) noexcept {
  count();
  return std::malloc(size == 0 ? 1 : size);
}

inline void* counted(std::size_t size, std::align_val_t alignment) noexcept {
  count();
  const auto multiple = static_cast<std::size_t>(alignment);
  return std::aligned_alloc(multiple, (size + multiple - 1) / multiple * multiple);
}

}  // namespace pavo::test

// Not inlined: g++ would see malloc in one place and delete in another, and warn. The ones that don't throw are
// replaced too: else the sanitizer's would meet our free (std::stable_sort uses them).
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (void* memory = pavo::test::counted(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return pavo::test::counted(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  if (void* memory = pavo::test::counted(size, alignment)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
