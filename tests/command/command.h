// The command as a process: called, looked at, interrupted; and small recordings to call it on.
#pragma once

#include <gmock/gmock.h>
#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tests/support/temporary.h"

namespace pavo::test {

using Words = std::vector<std::string>;

struct Called {
  int status = -1;  ///< 128 + its number where a signal ended it
  std::string out, error;
};

/// `pavo words...` that runs beside the test. Its destructor kills what still runs.
class Started {
 public:
  /// `before`: shell commands that set its limits.
  explicit Started(const Words& words, const std::string& before = ":");
  ~Started();
  Started(const Started&) = delete;
  Started& operator=(const Started&) = delete;

  void send(int signal) const;
  pid_t pid() const { return pid_; }
  /// Sleeps until the file has `lines` lines or the process has ended; false if it never had.
  bool wait_for_lines(const std::string& file, std::size_t lines);
  /// Waits for the end.
  Called wait();

 private:
  TemporaryFolder folder_;
  pid_t pid_ = -1;
};

Called pavo(const Words& words, const std::string& before = ":");

/// 12 frames of 320x96 of the synthetic street in KITTI's layout, made once a process and copied.
inline constexpr int kFrames = 12;
class Recording {
 public:
  Recording();
  std::string path() const { return folder_.file("street"); }
  std::string file(const std::string& name) const { return path() + "/" + name; }
  std::string image(int frame) const;
  void write(const std::string& name, const std::string& text) const { folder_.write("street/" + name, text); }
  void remove(const std::string& name) const { std::filesystem::remove_all(file(name)); }
  std::string out(const std::string& name = "out") const { return folder_.file(name); }
  /// `run PATH --out OUT --no-people` and more.
  Words run(const Words& more = {}) const;
  /// As many frames as are asked for, forth and back along the street, 20 a second; no truth.
  void make_long(int frames) const;

 private:
  TemporaryFolder folder_;
};

std::vector<std::string> lines_of(const std::string& path);
/// The fields of each line of a CSV file, its header first; quoted fields without their quotes.
std::vector<std::vector<std::string>> rows_of(const std::string& path);
nlohmann::json report_of(const std::string& out);

/// One line on stderr that is not empty, and nothing but that.
MATCHER(IsOneLine, "is one line") {
  return arg.size() > 1 && arg.find('\n') == arg.size() - 1;
}

/// in = done + failed + dropped, and a line for each in every file.
void expect_complete(const std::string& out);

}  // namespace pavo::test
