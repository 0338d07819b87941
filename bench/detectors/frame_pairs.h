// Pairs of consecutive frames whose relative pose is known.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "types/camera.h"
#include "types/image.h"
#include "types/pose.h"

namespace pavo::bench {

struct FramePair {
  std::int64_t frame = 0;  ///< the current one's index
  Image previous, current;
  SE3 T_c_p;  ///< true: maps points of the previous camera into the current one
};

struct DataSet {
  std::string name;
  Camera camera;
  std::vector<FramePair> pairs;
};

/// The synthetic street, and what of kitti05-300 and kitti-street-108 is in the folder that PAVO_DATA names. Every
/// `every`-th frame with the one before it. Says on stderr what is not there.
std::vector<DataSet> load_data_sets(int every);

}  // namespace pavo::bench
