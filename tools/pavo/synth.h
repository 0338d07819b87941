// `pavo synth`: the synthetic street as a KITTI folder.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand; see register_eval().
void register_synth(CLI::App& app, int& status);

}  // namespace pavo
