#include "bench/detectors/frame_pairs.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>

#include "drivers/sequences/sequence.h"
#include "drivers/synthetic/synthetic_street.h"
#include "stages/decode/decode.h"

namespace pavo::bench {
namespace {

DataSet pairs_of_sequence(const std::string& name, Sequence& sequence, int every) {
  const SequenceInfo& info = sequence.info();
  DataSet set{.name = name, .camera = info.camera.value(), .pairs = {}};
  std::map<std::int64_t, SE3> T_w_c;
  for (std::size_t i = 0; i < info.groundtruth->T_w_c.size(); ++i)
    T_w_c[info.groundtruth_frames[i]] = info.groundtruth->T_w_c[i];
  const Decode decode;
  Decode::Scratch scratch;
  EncodedImage encoded;
  FrameStamp stamp;
  FramePair pair;
  while (const auto next = sequence.peek()) {
    const std::int64_t phase = next->index % every;
    const bool is_previous = phase == every - 1, is_current = phase == 0 && next->index > 0;
    if (!is_previous && !is_current) {
      sequence.skip();
      continue;
    }
    sequence.read(encoded, stamp);
    decode(encoded, is_current ? pair.current : pair.previous, scratch);
    const bool known = T_w_c.contains(stamp.index) && T_w_c.contains(stamp.index - 1);
    if (!is_current || !known) continue;
    pair.frame = stamp.index;
    pair.T_c_p = T_w_c[stamp.index].inverse() * T_w_c[stamp.index - 1];
    set.pairs.push_back(std::exchange(pair, {}));
  }
  return set;
}

}  // namespace

std::vector<DataSet> load_data_sets(int every) {
  std::vector<DataSet> sets;
  SyntheticStreet street(SyntheticOptions{.frames = 180});
  sets.push_back(pairs_of_sequence("synthetic street", street, every));
  const char* data = std::getenv("PAVO_DATA");
  for (const char* name : {"kitti05-300", "kitti-street-108"}) {
    const std::filesystem::path folder = std::filesystem::path(data ? data : ".") / "sequences" / name;
    if (!data || !std::filesystem::is_directory(folder)) {
      std::fprintf(stderr, "%s is left out: set PAVO_DATA to the folder that has sequences/%s\n", name, name);
      continue;
    }
    sets.push_back(pairs_of_sequence(name, *open_sequence(folder.string()), every));
  }
  return sets;
}

}  // namespace pavo::bench
