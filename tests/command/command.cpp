#include "tests/command/command.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "drivers/synthetic/write_kitti.h"

extern char** environ;

namespace pavo::test {
namespace {

namespace fs = std::filesystem;

int status_of(int raw) {
  return WIFSIGNALED(raw) ? 128 + WTERMSIG(raw) : WEXITSTATUS(raw);
}

std::string frame_name(int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "%06d.png", frame);
  return name;
}

const std::string& street() {
  static const TemporaryFolder folder;
  static const std::string path = [] {
    SyntheticOptions options;
    options.frames = kFrames;
    options.width = 320;
    options.height = 96;
    write_kitti_folder(options, folder.file("street"));
    return folder.file("street");
  }();
  return path;
}

}  // namespace

Started::Started(const Words& words, const std::string& before) {
  const std::string script = before + "\nexec \"$@\"";
  const char* elsewhere = std::getenv("PAVO_COMMAND");  // another build's, a sanitizer's
  Words all{"/bin/sh", "-c", script, "sh", elsewhere ? elsewhere : PAVO_COMMAND};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> argv;
  for (std::string& word : all) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, folder_.file("out").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  posix_spawn_file_actions_addopen(&files, 2, folder_.file("err").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  if (posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ) != 0) ADD_FAILURE() << "not started";
  posix_spawn_file_actions_destroy(&files);
}

Started::~Started() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

void Started::send(int signal) const {
  ::kill(pid_, signal);
}

bool Started::wait_for_lines(const std::string& file, std::size_t lines) {
  for (;;) {
    const bool there = lines_of(file).size() >= lines;
    siginfo_t info{};
    ::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT);
    if (there || info.si_pid == pid_) return there;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

Called Started::wait() {
  int raw = 0;
  ::waitpid(pid_, &raw, 0);
  pid_ = -1;
  return {status_of(raw), bytes_of(folder_.file("out")), bytes_of(folder_.file("err"))};
}

Called pavo(const Words& words, const std::string& before) {
  return Started(words, before).wait();
}

Recording::Recording() {
  fs::copy(street(), path(), fs::copy_options::recursive);
}

std::string Recording::image(int frame) const {
  return file("image_0/" + frame_name(frame));
}

Words Recording::run(const Words& more) const {
  Words words{"run", path(), "--out", out(), "--no-people"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void Recording::make_long(int frames) const {
  fs::rename(file("image_0"), file("seen"));
  fs::create_directory(file("image_0"));
  std::ostringstream times;
  constexpr int kPeriod = 2 * (kFrames - 1);
  for (int i = 0; i < frames; ++i) {
    const int at = i % kPeriod < kFrames ? i % kPeriod : kPeriod - i % kPeriod;
    fs::create_symlink("../seen/" + frame_name(at), image(i));
    times << 0.05 * i << '\n';
  }
  write("times.txt", times.str());
  remove("poses.txt");
}

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::vector<std::vector<std::string>> rows_of(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : lines_of(path)) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        fields.emplace_back();
      else
        fields.back() += c;
    }
    rows.push_back(fields);
  }
  return rows;
}

nlohmann::json report_of(const std::string& out) {
  return nlohmann::json::parse(bytes_of(out + "/report.json"), nullptr, false);
}

void expect_complete(const std::string& out) {
  const nlohmann::json report = report_of(out);
  ASSERT_FALSE(report.is_discarded()) << "no report";
  const auto count = [&](const char* name) { return report["frames"][name].get<std::size_t>(); };
  EXPECT_EQ(count("in"), count("done") + count("failed") + count("dropped"));
  EXPECT_EQ(count("in_flight"), 0u);
  std::size_t dropped_by = 0;
  for (const auto& reason : report["frames"]["dropped_by"]) dropped_by += reason.get<std::size_t>();
  EXPECT_EQ(dropped_by, count("dropped"));
  EXPECT_EQ(lines_of(out + "/trajectory.kitti").size(), count("in"));
  EXPECT_EQ(lines_of(out + "/trajectory.tum").size(), count("in"));

  const auto rows = rows_of(out + "/frames.csv");
  ASSERT_EQ(rows.size(), count("in") + 1);
  std::size_t done = 0, failed = 0, dropped = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), rows[0].size()) << "frames.csv:" << i + 1;
    EXPECT_EQ(rows[i][0], std::to_string(i - 1));
    done += rows[i][2] == "done";
    failed += rows[i][2] == "failed";
    dropped += rows[i][2] == "dropped";
  }
  EXPECT_EQ(done, count("done"));
  EXPECT_EQ(failed, count("failed"));
  EXPECT_EQ(dropped, count("dropped"));
}

}  // namespace pavo::test
