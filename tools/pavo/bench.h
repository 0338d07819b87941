// `pavo bench`: how many frames a second, and with what latency, on this machine.
#pragma once

#include <CLI/CLI.hpp>

namespace pavo {

void register_bench(CLI::App& app, int& status);

}  // namespace pavo
