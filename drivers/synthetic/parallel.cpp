#include "drivers/synthetic/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace pavo::synthetic {

void for_each_index(int count, int threads, const std::function<void(int)>& f) {
  const int cores = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  const int helpers = std::min(threads == 0 ? cores : threads, count) - 1;
  std::atomic<int> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) f(i);
    } catch (...) {
      next.store(count);
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> team;
    team.reserve(static_cast<std::size_t>(std::max(0, helpers)));
    for (int i = 0; i < helpers; ++i) team.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace pavo::synthetic
