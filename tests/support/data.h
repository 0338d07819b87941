// Where the real sequences are, for the tests that want them.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace pavo::test {

/// The folder that PAVO_DATA names, else the one beside the project.
inline std::filesystem::path data_folder() {
  if (const char* named = std::getenv("PAVO_DATA")) return named;
  return std::filesystem::path(PAVO_SOURCE_DIR) / ".." / "shared" / "data";
}

}  // namespace pavo::test

/// Skips the test, saying which data it would have needed, on a machine that does not have it.
#define PAVO_NEEDS_DATA(relative)                                               \
  if (!std::filesystem::exists(pavo::test::data_folder() / (relative)))         \
  GTEST_SKIP() << "needs " << (pavo::test::data_folder() / (relative)).string() \
               << " (set PAVO_DATA to the folder with the recorded sequences)"
