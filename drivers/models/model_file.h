// The pedestrian classifier as a file.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "types/pedestrian_model.h"

namespace pavo {

/// The text of a model:
///
///     pavo-pedestrian-model 1
///     # any number of lines that begin with '#', anywhere
///     tone square_root                 or linear
///     epsilon 100
///     clip 0.2
///     fade 0.1
///     calibration 2.5 -1.25            slope and offset
///     threshold 0.5
///     bias -0.75
///     weights 3780
///     ... 105 lines of 36 numbers, a block each, by rows of the window
///     end
///
/// Numbers are written so that they are read back to the bit, in every locale.
std::string pedestrian_model_text(const PedestrianModel& model, std::string_view comment = {});

/// Reads such a text; or 3780 or 3781 plain numbers, separated by blanks, commas or lines, in the order of OpenCV's
/// cv::HOGDescriptor (blocks and cells by columns; the last one is the bias), for 64x128 windows and OpenCV's other
/// defaults. Their features are not quite ours (stages/people/hog.h), their margins are close; the calibration is 1:1
/// and the threshold a margin of 0. `name` is for messages. Throws std::runtime_error with one line that names the line
/// and what was expected: text that is cut off, another version, numbers that are none, too few, too many, not finite
/// or out of range.
PedestrianModel parse_pedestrian_model(std::string_view text, const std::string& name);

/// The same from a file of at most 16 MiB.
PedestrianModel read_pedestrian_model(const std::filesystem::path& file);

/// Writes a new file beside it, then renames: whatever happens (a full disk, say), `file` is the old one or the new
/// one, whole. Throws std::runtime_error.
void write_pedestrian_model(const PedestrianModel& model, const std::filesystem::path& file,
                            std::string_view comment = {});

/// The model that is part of the program: models/pedestrian.txt, embedded when it was built.
PedestrianModel default_pedestrian_model();

}  // namespace pavo
