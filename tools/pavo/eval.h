// `pavo eval`: how far estimated trajectories are from the true one.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand. When it is called, it prints its tables to stdout, writes the files it was asked for and sets
/// `status` to 0; whatever goes wrong is an exception with a message of one line. `status` must outlive the parse.
void register_eval(CLI::App& app, int& status);

}  // namespace pavo
