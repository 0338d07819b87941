// `pavo detect`: people in single pictures.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand; see register_eval().
void register_detect(CLI::App& app, int& status);

}  // namespace pavo
