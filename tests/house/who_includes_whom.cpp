// The house's rules, read from the includes: the engine knows no vision, stages know no threads and no files, drivers
// know no stages, and nobody but tools and benchmarks reaches upwards.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = PAVO_SOURCE_DIR;
const std::vector<std::string> kFolders{"engine", "types", "stages", "drivers", "pavo",
                                        "tools",  "bench", "tests",  "examples"};

struct Include {
  std::string file;  ///< "stages/pose/odometry.h"
  int line = 0;
  std::string what;  ///< "opencv2/core.hpp"
  bool quoted = false;
  std::string place() const { return file + ":" + std::to_string(line) + ": " + what; }
};

bool is_source(const fs::path& path) {
  return path.extension() == ".h" || path.extension() == ".cpp" || path.extension() == ".hpp";
}

/// f(line, "FILE:NUMBER: LINE") for all sources of a folder.
template <typename F>
void for_each_line(const std::string& folder, F f) {
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    if (!entry.is_regular_file() || !is_source(entry.path())) continue;
    std::ifstream file(entry.path());
    int number = 0;
    for (std::string line; std::getline(file, line);)
      f(line, entry.path().lexically_relative(kRoot).string() + ":" + std::to_string(++number) + ": " + line);
  }
}

std::vector<Include> includes_of(const std::string& folder) {
  static const std::regex form(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"].*)re");
  std::vector<Include> includes;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    if (!entry.is_regular_file() || !is_source(entry.path())) continue;
    std::ifstream file(entry.path());
    int number = 0;
    for (std::string line; std::getline(file, line);) {
      ++number;
      std::smatch match;
      if (std::regex_match(line, match, form))
        includes.push_back({entry.path().lexically_relative(kRoot).string(), number, match[2], match[1] == "\""});
    }
  }
  EXPECT_FALSE(includes.empty()) << folder;
  return includes;
}

std::string top_of(const std::string& path) {
  return path.substr(0, path.find('/'));
}

bool is_own(const Include& include) {
  return std::find(kFolders.begin(), kFolders.end(), top_of(include.what)) != kFolders.end();
}

void expect_own_only_from(const std::string& folder, const std::vector<std::string>& allowed) {
  for (const Include& include : includes_of(folder)) {
    if (!is_own(include)) continue;
    EXPECT_NE(std::find(allowed.begin(), allowed.end(), top_of(include.what)), allowed.end()) << include.place();
  }
}

/// `what`: a regular expression of whole names. `exceptions`: "FILE: INCLUDE".
void expect_none(const std::string& folder, const std::string& what, const std::vector<std::string>& exceptions = {}) {
  const std::regex pattern(what);
  for (const Include& include : includes_of(folder)) {
    const std::string name = include.file + ": " + include.what;
    const bool known = std::find(exceptions.begin(), exceptions.end(), name) != exceptions.end();
    EXPECT_FALSE(!known && std::regex_match(include.what, pattern)) << include.place();
  }
}

TEST(House, TheEngineKnowsNoVision) {
  expect_own_only_from("engine", {"engine"});
  expect_none("engine", "opencv2/.*|Eigen/.*|hwy/.*|nlohmann/.*");
}

TEST(House, TypesAreMadeOfNothingButEigen) {
  expect_own_only_from("types", {"types"});
  expect_none("types", "opencv2/.*|hwy/.*|tbb/.*|nlohmann/.*|thread|mutex|atomic|fstream|filesystem");
}

TEST(House, StagesKnowNoThreadsFilesOrDevices) {
  expect_own_only_from("stages", {"stages", "types"});
  expect_none("stages", "thread|mutex|shared_mutex|condition_variable|future|semaphore|barrier|latch|stop_token");
  // libpng's header wants FILE; OpenCV decodes BMP and TIFF from memory.
  expect_none("stages", "pthread.h|fstream|filesystem|cstdio|stdio.h|fcntl.h|unistd.h|sys/.*|linux/.*",
              {"stages/decode/png.cpp: cstdio", "stages/decode/jpeg.cpp: cstdio"});
  expect_none("stages", "opencv2/(highgui|imgcodecs|videoio).*|spdlog/.*",
              {"stages/decode/bmp_tiff.cpp: opencv2/imgcodecs.hpp"});
  for_each_line("stages", [](const std::string& line, const std::string& place) {
    static const std::regex files(R"([^/]*\b(imread|imwrite|fopen|FileStorage)\b[^/]*)");
    EXPECT_FALSE(std::regex_match(line, files)) << place;
  });
}

TEST(House, DriversKnowNoStages) {
  expect_own_only_from("drivers", {"drivers", "types"});
}

TEST(House, TheAssemblyKnowsNoCommand) {
  expect_own_only_from("pavo", {"engine", "types", "stages", "drivers", "pavo"});
}

TEST(House, OnlyTestsKnowTests) {
  for (const char* folder : {"tools", "bench"}) {
    for (const Include& include : includes_of(folder)) {
      const std::string top = top_of(include.what);
      EXPECT_FALSE(top == "tests" || (top == "bench" && top != folder)) << include.place();
    }
  }
}

TEST(House, TheInstalledHeadersDragNothingIn) {
  for (const std::string folder : {"pavo", "types"})
    for (const Include& include : includes_of(folder)) {
      if (include.file != "pavo/visual_odometry.h" && include.file != "types/camera.h") continue;
      if (include.quoted) {
        EXPECT_EQ(include.what, "types/camera.h") << include.place();
      } else {
        EXPECT_EQ(include.what.find_first_of("./"), std::string::npos) << include.place() << " is not of the standard";
      }
    }
}

TEST(House, IncludesAreWrittenFromTheRoot) {
  for (const std::string& folder : kFolders) {
    if (folder == "examples" || !fs::exists(kRoot / folder)) continue;  // they see the installed headers
    for (const Include& include : includes_of(folder)) {
      if (!include.quoted) continue;
      EXPECT_TRUE(fs::exists(kRoot / include.what)) << include.place();
    }
  }
}

TEST(House, HeadersIncludeEachOtherInNoCircle) {
  std::map<std::string, std::vector<std::string>> graph;
  for (const char* folder : {"engine", "types", "stages", "drivers", "pavo", "tools"})
    for (const Include& include : includes_of(folder))
      if (include.file.ends_with(".h") && is_own(include)) graph[include.file].push_back(include.what);
  std::map<std::string, int> state;  // 1: being visited, 2: done
  std::vector<std::string> path;
  const auto visit = [&](const auto& self, const std::string& file) -> void {
    if (state[file] == 2) return;
    path.push_back(file);
    EXPECT_NE(state[file], 1) << ::testing::PrintToString(path);
    if (state[file] == 1) return path.pop_back();
    state[file] = 1;
    for (const std::string& next : graph[file]) self(self, next);
    state[file] = 2;
    path.pop_back();
  };
  std::vector<std::string> files;
  for (const auto& [file, next] : graph) files.push_back(file);
  for (const std::string& file : files) visit(visit, file);
}

TEST(House, OnlyTheToolsPrint) {
  const std::regex printing(R"(.*\b(std::cout|std::cerr|printf\s*\(|std::puts|fmt::print\b).*)");
  for (const char* folder : {"engine", "types", "stages", "drivers", "pavo"})
    for_each_line(folder, [&](const std::string& line, const std::string& place) {
      EXPECT_FALSE(std::regex_match(line, printing)) << place;
    });
}

}  // namespace
