// `pavo devices`: the cameras of this machine, what they offer and what can be turned on them.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// `status` is set when the subcommand was called.
void register_devices(CLI::App& app, int& status);

}  // namespace pavo
