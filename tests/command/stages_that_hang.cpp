// A stage that hangs: named within its limit, all before it written, status 1. It hangs because one of the command's
// workers is stopped in the middle of it, as a debugger stops a thread.
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <thread>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

namespace fs = std::filesystem;

/// A worker of the command that is at work; 0: all sleep.
pid_t busy_worker(pid_t process) {
  std::error_code gone;
  for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(process) + "/task", gone)) {
    std::string line;
    std::getline(std::ifstream(task.path() / "stat"), line);  // tid (name) state ...
    if (std::regex_search(line, std::regex(R"(\(pavo-worker[0-9]\) R)"))) return static_cast<pid_t>(std::stoi(line));
  }
  return 0;
}

/// A thread that does not go on any more.
class Stopped {
 public:
  static std::optional<Stopped> stop(pid_t thread) {
    if (::ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0) return std::nullopt;
    ::ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr);
    ::waitpid(thread, nullptr, __WALL);
    return Stopped(thread);
  }
  /// It wakes another thread, or sleeps: that is the engine, between two stages.
  bool is_between_stages() const {
    std::string number;
    std::ifstream("/proc/" + std::to_string(thread_) + "/syscall") >> number;
    return number == std::to_string(SYS_futex);
  }
  void go_on() const { ::ptrace(PTRACE_DETACH, thread_, nullptr, nullptr); }
  /// Whether its process ends within that time.
  bool ends_within(std::chrono::seconds time) const {
    const auto until = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < until) {
      if (::waitpid(thread_, nullptr, __WALL | WNOHANG) == thread_) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

 private:
  explicit Stopped(pid_t thread) : thread_(thread) {}
  pid_t thread_;
};

// Nothing where the thread could not be stopped, or was between two stages when it was. `stopped_any`: it was stopped.
std::optional<Called> call_with_a_hanging_stage(const Recording& recording, bool& stopped_any) {
  // One worker: of two, one often looks for something to do.
  Started run(recording.run({"--config", recording.file("limit.toml"), "--workers", "1"}));
  if (!run.wait_for_lines(recording.out() + "/trajectory.kitti", 20)) return std::nullopt;
  std::optional<Stopped> stopped;
  for (int looks = 0; !stopped && looks < 10'000; ++looks) {
    const pid_t worker = busy_worker(run.pid());
    if (worker == 0) continue;
    stopped = Stopped::stop(worker);
    if (!stopped) return std::nullopt;
    if (!stopped->is_between_stages()) break;
    stopped->go_on();
    stopped.reset();
  }
  if (!stopped) return std::nullopt;
  stopped_any = true;
  if (stopped->ends_within(std::chrono::seconds(20))) return run.wait();
  run.send(SIGKILL);
  stopped->ends_within(std::chrono::seconds(20));
  return std::nullopt;
}

// Where the delivery itself hangs, there is no way out. And on a busy machine another stage may be over the limit and
// come back: that is told too, but nothing is lost then.
bool is_of_the_stopped_one(const std::smatch& told, const Recording& recording) {
  const auto rows = rows_of(recording.out() + "/frames.csv");
  const auto row = static_cast<std::size_t>(std::stoul(told[2])) + 1;
  return told[1] != "delivery" && row < rows.size() && rows[row][2] != "done";
}

TEST(StageThatHangs, IsNamedWhenAllBeforeItIsWritten) {
  const Recording recording;
  recording.make_long(3000);
  recording.write("limit.toml", "[engine]\nstage_limit_s = 3\n");
  const std::regex told("pavo: .*: stage '([a-z]+)' has held frame ([0-9]+) for more than 3 s: it hangs\n");
  std::smatch words;
  std::optional<Called> called;
  bool stopped_any = false;
  for (int attempt = 0; attempt < 5 && words.empty(); ++attempt) {
    fs::remove_all(recording.out());
    called = call_with_a_hanging_stage(recording, stopped_any);
    if (called && std::regex_search(called->error, words, told) && !is_of_the_stopped_one(words, recording)) words = {};
  }
  if (!stopped_any) GTEST_SKIP() << "the system lets no thread be stopped";
  ASSERT_TRUE(called) << "a worker was stopped, and the run did not end";
  ASSERT_EQ(words.size(), 3u) << called->error;

  EXPECT_EQ(called->status, 1);
  const auto hung = static_cast<std::size_t>(std::stoul(words[2]));
  const auto rows = rows_of(recording.out() + "/frames.csv");
  ASSERT_GT(rows.size(), hung + 1) << "the frames that were under way, too";
  for (std::size_t frame = 0; frame + 1 < rows.size(); ++frame)
    EXPECT_EQ(rows[frame + 1][2] == "done", frame < hung) << "frame " << frame << " is " << rows[frame + 1][2];
  EXPECT_EQ(lines_of(recording.out() + "/trajectory.kitti").size(), rows.size() - 1);
  EXPECT_EQ(report_of(recording.out())["frames"]["done"], hung);
}

}  // namespace
}  // namespace pavo::test
