#include "tools/pavo/bench_machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <sstream>
#include <thread>

#include "pavo/simd.h"

namespace pavo {
namespace {

std::string first_line(const char* path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name") && line.find(": ") != std::string::npos) return line.substr(line.find(": ") + 2);
  return "unknown";
}

std::string kernel_name() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return std::string(name.sysname) + " " + name.release + " " + name.machine;
}

}  // namespace

Machine this_machine() {
  const std::string governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  return {.cpu = cpu_name(),
          .cores = static_cast<int>(std::thread::hardware_concurrency()),
          .governor = governor.empty() ? "none" : governor,
          .kernel = kernel_name(),
          .simd = simd_target(),
          .compiler = __VERSION__,
          .version = PAVO_VERSION};
}

OtherWork::OtherWork() : start_(ticks()), own_start_s_(own_cpu_s()) {}

OtherWork::Ticks OtherWork::ticks() {
  std::istringstream line(first_line("/proc/stat"));
  std::string cpu;
  std::int64_t user = 0, nice = 0, system = 0, idle = 0, wait = 0, irq = 0, softirq = 0, stolen = 0;
  if (!(line >> cpu >> user >> nice >> system >> idle >> wait >> irq >> softirq >> stolen)) return {};
  const std::int64_t busy = user + nice + system + irq + softirq;
  return {busy, stolen, busy + stolen + idle + wait};
}

double OtherWork::own_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

OtherWork::Share OtherWork::others() const {
  const Ticks now = ticks();
  const auto all = static_cast<double>(now.all - start_.all);
  if (all <= 0) return {};
  const double own = (own_cpu_s() - own_start_s_) * static_cast<double>(sysconf(_SC_CLK_TCK));
  const double others = std::max(0.0, static_cast<double>(now.busy - start_.busy) - own);
  return {.percent = 100 * others / all, .stolen_percent = 100 * static_cast<double>(now.stolen - start_.stolen) / all};
}

}  // namespace pavo
