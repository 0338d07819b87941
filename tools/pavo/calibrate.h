// `pavo calibrate`: from pictures of a chessboard, or from a camera that watches one, to the camera's calibration.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand; see register_eval().
void register_calibrate(CLI::App& app, int& status);

}  // namespace pavo
