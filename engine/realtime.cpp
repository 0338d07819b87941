#include "engine/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>

namespace pavo {

std::string pin_this_thread(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (cpu >= 0 && cpu < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(cpu), &set);
  const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  if (error == 0) return "";
  return "not pinned to cpu " + std::to_string(cpu) + ": " + std::strerror(error) + "; nproc tells how many there are";
}

std::string make_this_thread_fifo(int priority) {
  const sched_param parameters{.sched_priority = priority};
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error == 0) return "";
  return "SCHED_FIFO at priority " + std::to_string(priority) + " was refused: " + std::strerror(error) +
         "; it needs CAP_SYS_NICE or `ulimit -r " + std::to_string(priority) + "`";
}

void make_this_thread_ordinary() {
  const sched_param parameters{.sched_priority = 0};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &parameters);
}

std::string lock_all_memory() {
  // With a limit, memory that is to be locked in future would be refused when it is asked for, in the middle of the
  // run.
  rlimit limit{};
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  if (mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0) return "";
  return std::string("the memory is not locked: ") + std::strerror(errno) +
         "; it needs CAP_IPC_LOCK or `ulimit -l unlimited`";
}

}  // namespace pavo
