// Where a training stands, as a file beside the model: what makes it possible to stop and go on.
#pragma once

#include <optional>
#include <string>

#include "stages/people/train.h"

namespace pavo {

/// `fingerprint` is one line that tells one training (its data and options) from another.
void write_train_state(const std::string& file, const TrainState& state, const std::string& fingerprint);

/// The state, or nothing if there is no such file. Throws std::runtime_error if it is of another training, or broken.
std::optional<TrainState> read_train_state(const std::string& file, const std::string& fingerprint);

}  // namespace pavo
