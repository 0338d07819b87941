// What the tests in the virtual machine share: buttons to press, descriptors to count, a webcam to pull out.
#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/v4l2/live_camera.h"

namespace pavo::v4l2::test {

inline const std::string kVivid = "/dev/video0";
inline const std::string kMultiPlanar = "/dev/video1";
inline const std::string kWebcam = "/dev/video2";  // uvcsim's; its metadata are at the next one
inline const std::string kHonestStamps = "timestamp_source=Start of Exposure";

inline CameraOptions asking_for(const FrameSize& size, double rate_hz, const std::string& format = "",
                                const std::string& controls = "", bool every_frame = true) {
  CameraOptions options;
  options.format.size = size;
  options.format.rate_hz = rate_hz;
  options.format.format = format;
  options.buffers = 8;
  options.controls = parse_controls(controls);
  options.every_frame = every_frame;
  return options;
}

/// Sets a control of vivid while somebody else streams from it.
inline void press(const std::string& control, const std::string& value = "1", const std::string& node = kVivid) {
  Kernel kernel;
  const Device device(kernel, node);
  set_controls(device, {{control, value}});
}

inline int open_descriptors(const std::string& process = "self") {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + process + "/fd")) count += entry.exists();
  return count;
}

/// Of a camera's buffers.
inline int mapped_buffers(const std::string& process = "self") {
  std::ifstream maps("/proc/" + process + "/maps");
  int count = 0;
  for (std::string line; std::getline(maps, line);) count += line.find("/dev/video") != std::string::npos;
  return count;
}

/// Under emulation all takes its time: a minute, looked at often.
template <class Condition>
bool eventually(Condition&& condition) {
  for (int n = 0; n < 3000; ++n) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return condition();
}

inline void write_file(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
}

inline std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Whether the build that is tested finds errors of memory; then it has to be that of the command, too.
inline constexpr bool kSanitized =
#ifdef __SANITIZE_ADDRESS__
    true;
#else
    false;
#endif

/// A program that runs beside the test; killed at the end.
class Child {
 public:
  Child(std::vector<std::string> words, const std::string& output) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    EXPECT_EQ(posix_spawn(&pid_, arguments[0], &files, nullptr, arguments.data(), environ), 0) << words[0];
    posix_spawn_file_actions_destroy(&files);
  }
  ~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void send(int signal) const { ::kill(pid_, signal); }
  std::string pid() const { return std::to_string(pid_); }
  /// The exit status, 128 + the signal's number.
  int wait() {
    int status = 0;
    ::waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }

 private:
  pid_t pid_ = -1;
};

/// The command that is tested, with these words. Whatever a sanitizer finds in it, a leak as well, is a failure.
class Pavo : public Child {
 public:
  Pavo(std::vector<std::string> words, const std::string& log)
      : Child(with_command(std::move(words)), log), log_(log) {}

  int wait() {
    const int status = Child::wait();
    EXPECT_THAT(text_of(log_), ::testing::Not(::testing::HasSubstr("Sanitizer")));
    return status;
  }

 private:
  std::string log_;
  static std::vector<std::string> with_command(std::vector<std::string> words) {
    words.insert(words.begin(), std::getenv("PAVO"));
    return words;
  }
};

/// A simulated webcam on the kernel's own uvcvideo, plugged in.
class Webcam {
 public:
  /// `forces` is "FORMAT FRAME", by number: what it gives whatever it is asked for (uvcsim.cpp).
  explicit Webcam(const char* forces = "0 0") : simulator_(program(forces), "/tmp/uvcsim.log") { wait_for_node(true); }
  ~Webcam() {  // the next test's webcam is not to be taken for this one on its way out
    if (plugged_in_) pull_out();
  }
  Webcam(const Webcam&) = delete;
  Webcam& operator=(const Webcam&) = delete;
  /// From now on it shows this: a PGM of the size that is streamed, or a JPEG where the format is MJPG.
  static void show(const std::string& file) {
    write_file(kPicture + ".new", file);
    std::filesystem::rename(kPicture + ".new", kPicture);
  }
  void pull_out() {
    simulator_.send(SIGUSR1);
    wait_for_node(false);
    plugged_in_ = false;
  }
  void plug_in() {
    simulator_.send(SIGUSR2);
    wait_for_node(true);
    plugged_in_ = true;
  }

 private:
  inline static const std::string kPicture = "/tmp/picture";

  static std::vector<std::string> program(const char* forces) {
    std::filesystem::remove(kPicture);
    ::setenv("UVCSIM_FORCES", forces, 1);
    ::setenv("UVCSIM_PICTURE", kPicture.c_str(), 1);
    return {std::getenv("UVCSIM")};
  }
  // A node that is there may be one that is going: only one that opens is there.
  static bool opens() {
    const int fd = ::open(kWebcam.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fd >= 0) ::close(fd);
    return fd >= 0;
  }
  static void wait_for_node(bool there) {
    ASSERT_TRUE(eventually([&] { return there ? opens() : !std::filesystem::exists(kWebcam); })) << there;
  }
  Child simulator_;
  bool plugged_in_ = true;
};

}  // namespace pavo::v4l2::test
