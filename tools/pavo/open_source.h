// SOURCE on the command line.
#pragma once

#include <memory>
#include <string>

#include "drivers/sequences/sequence.h"
#include "pavo/config.h"

namespace pavo {

/// `synthetic`, or what the drivers recognise. Throws std::runtime_error of one line.
std::unique_ptr<Sequence> open_source(const std::string& source, const Config& config);

}  // namespace pavo
