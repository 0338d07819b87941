// `pavo record`: a camera's frames, or a sequence's, as a sequence that `pavo run` replays to the same bits.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand; see register_eval().
void register_record(CLI::App& app, int& status);

}  // namespace pavo
