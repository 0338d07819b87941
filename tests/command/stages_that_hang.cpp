// A stage that hangs: named within its limit, all before it written, status 1. It hangs because one of the command's
// workers is stopped in the middle of it, as a debugger stops a thread.
#include <sys/ptrace.h>
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

// Nothing where the thread could not be stopped, or was between two stages when it was.
std::optional<Called> call_with_a_hanging_stage(const Recording& recording) {
  Started run(recording.run({"--config", recording.file("limit.toml"), "--workers", "2"}));
  if (!run.wait_for_lines(recording.out() + "/trajectory.kitti", 20)) return std::nullopt;
  pid_t worker = 0;
  for (int looks = 0; worker == 0 && looks < 10'000; ++looks) worker = busy_worker(run.pid());
  const std::optional<Stopped> stopped = worker == 0 ? std::nullopt : Stopped::stop(worker);
  if (!stopped) return std::nullopt;
  if (stopped->ends_within(std::chrono::seconds(10))) return run.wait();
  run.send(SIGKILL);
  stopped->ends_within(std::chrono::seconds(10));
  return std::nullopt;
}

TEST(StageThatHangs, IsNamedWhenAllBeforeItIsWritten) {
  const Recording recording;
  recording.make_long(3000);
  recording.write("limit.toml", "[engine]\nstage_limit_s = 1\n");
  const std::regex told("pavo: .*: stage '([a-z]+)' has held frame ([0-9]+) for more than 1 s: it hangs\n");
  std::smatch words;
  std::optional<Called> called;
  for (int attempt = 0; attempt < 5 && words.empty(); ++attempt) {
    fs::remove_all(recording.out());
    called = call_with_a_hanging_stage(recording);
    // Where the delivery itself hangs, there is no way out.
    if (called && std::regex_search(called->error, words, told) && words[1] == "delivery") words = {};
  }
  if (!called) GTEST_SKIP() << "the system lets no thread be stopped";
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
