// `pavo undistort`: pictures without their lens's distortion, as `pavo run` sees them.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand; see register_eval().
void register_undistort(CLI::App& app, int& status);

}  // namespace pavo
