// `pavo run`: a source's frames into a trajectory, a picture and a report.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand; see register_eval().
void register_run(CLI::App& app, int& status);

}  // namespace pavo
