// The command `pavo`: one subcommand a file, and one way to end.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "pavo/nearest_word.h"
#include "tools/pavo/bench.h"
#include "tools/pavo/calibrate.h"
#include "tools/pavo/detect.h"
#include "tools/pavo/devices.h"
#include "tools/pavo/eval.h"
#include "tools/pavo/record.h"
#include "tools/pavo/run.h"
#include "tools/pavo/synth.h"
#include "tools/pavo/train.h"
#include "tools/pavo/undistort.h"

namespace {

constexpr int kWrongCall = 2;

// "; did you mean --workers?", for the first word on the command line that no command or option is called by.
struct Unknown {
  std::string word;
  std::string advice;
};

Unknown unknown_word(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = &app;
  for (const CLI::App* sub : app.get_subcommands()) command = sub;
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    for (const std::string& name : option->get_snames()) known.push_back("-" + name);
  }
  if (command == &app)
    for (const CLI::App* sub : app.get_subcommands(nullptr)) known.push_back(sub->get_name());
  const std::vector<std::string_view> candidates(known.begin(), known.end());
  const std::string see = "; see pavo " + (command == &app ? "" : command->get_name() + " ") + "--help";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = std::string_view(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    const bool is_option = word.size() > 1 && word[0] == '-' && !std::isdigit(word[1]) && word[1] != '.';
    if (!is_option && command != &app) continue;
    if (std::find(candidates.begin(), candidates.end(), word) != candidates.end()) continue;
    const bool is_short = is_option && word[1] != '-';  // near to every other
    if (const auto nearest = pavo::nearest_word(word, candidates); !nearest.empty() && !is_short)
      return {std::string(word), "; did you mean " + std::string(nearest) + "?"};
    if (is_option || command == &app) return {std::string(word), see};
  }
  return {"", see};
}

std::string what_is_wrong(const CLI::ParseError& error, const CLI::App& app, int argc, char** argv) {
  const bool leftover = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
  const bool no_command = app.get_subcommands().empty();
  const Unknown unknown = unknown_word(app, argc, argv);
  if ((leftover || no_command) && unknown.word.starts_with("-"))
    return "no such option: " + unknown.word + unknown.advice;
  if (no_command && !unknown.word.empty()) return "no such command: " + unknown.word + unknown.advice;
  return error.what() + unknown.advice;
}

// Output that is lost, on a full disk, say, is an error as any other.
int with_output_written(int status) {
  if (std::cout.flush() && std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
  std::fprintf(stderr, "pavo: standard output cannot be written\n");
  return 1;
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // the threads are ours: OpenCV makes none of its own, in any command
  CLI::App app{"pavo: pedestrian-aware visual odometry. One calibrated camera's frames in, its trajectory out."};
  app.name("pavo");
  app.footer("Example: pavo run synthetic --out out/\nEach command has its own --help.");
  app.require_subcommand(1);
  int status = 1;
  pavo::register_run(app, status);
  pavo::register_eval(app, status);
  pavo::register_bench(app, status);
  pavo::register_synth(app, status);
  pavo::register_detect(app, status);
  pavo::register_devices(app, status);
  pavo::register_train(app, status);
  pavo::register_calibrate(app, status);
  pavo::register_undistort(app, status);
  pavo::register_record(app, status);
  app.set_version_flag("--version", "pavo " PAVO_VERSION);
  for (CLI::App* command : app.get_subcommands(nullptr)) command->set_version_flag("--version", "pavo " PAVO_VERSION);
  // Errors are told once, in one line, by us. Who looks for the cause in OpenCV sets its own variable.
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // FFmpeg's own lines; what went wrong is told by us, in one
  if (!std::getenv("OPENCV_LOG_LEVEL")) cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  try {
    app.parse(argc, argv);
    return with_output_written(status);
  } catch (const CLI::Success& e) {
    return with_output_written(app.exit(e));  // --help, --version
  } catch (const CLI::ParseError& e) {
    std::fprintf(stderr, "pavo: %s\n", one_line(what_is_wrong(e, app, argc, argv)).c_str());
    return kWrongCall;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "pavo: %s\n", one_line(e.what()).c_str());
    return 1;
  }
}
