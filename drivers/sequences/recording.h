// What the openers of the layouts have in common: frames, times and calibration of a recording.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/calibration/calibration.h"
#include "drivers/sequences/image_sequence.h"

namespace pavo {

/// All images of `folder`, without times. Throws where there is none.
Recording record_images(const std::string& layout, const std::string& source, const std::filesystem::path& folder);

/// The line of a file (from 0) that belongs to each frame. As many lines as frames: in order. More lines: frame 000007
/// is line 7, if all frames are numbered so; else an error. Fewer lines: the frames behind the last have none.
std::vector<std::size_t> lines_of_frames(const std::vector<FrameFile>& frames, std::size_t lines,
                                         const std::string& file);

/// Gives the frames the times of a file with one of them per line. Throws where there are fewer times than frames.
void take_times(Recording& recording, const std::vector<std::int64_t>& times_ns, const std::string& file);

/// Where there are no times: those that --rate gives, or the frames' numbers.
void take_rate(Recording& recording, double rate_hz);

/// Fills camera (with its size) and calibration_source from the file that the options name, else from the one of
/// `candidates` that there is: two of them are an error, none of them leaves the camera out and says what was looked
/// for. Throws where the calibration is malformed, or is not for images of this size.
std::optional<Calibration> take_calibration(Recording& recording, const SequenceOptions& options,
                                            const std::vector<std::filesystem::path>& candidates,
                                            std::optional<int> kitti_camera = {});

}  // namespace pavo
