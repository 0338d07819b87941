// `pavo train`: pictures with and without people into a classifier.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

/// Adds the subcommand; see register_eval().
void register_train(CLI::App& app, int& status);

}  // namespace pavo
