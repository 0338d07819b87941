#include <algorithm>
#include <cmath>

#include "stages/ground/align_ground.h"

namespace pavo {
namespace {

// What a block shows where it is compared with something that it has nothing to do with, or does not move at all.
float unlike(const AlignGround::Block& b) {
  return std::min(b.variance / static_cast<float>(b.pixels), b.at_rest) + 1.0f;
}

// How much a block has to say: one with little texture little.
double voice(const AlignGround::Block& b) {
  constexpr float kTexture = 4000;
  return std::min(1.0f, unlike(b) / kTexture);
}

}  // namespace

void AlignGround::vote(const GroundImage& current, const GroundImage& reference, const SE3& T_ref_cur,
                       const GroundAttitude& attitude, double pitch_sigma, double height_m, const People& people,
                       ScaleVotes& votes) {
  constexpr int kLevel = 2, kPitches = 5;
  constexpr double kShortest = 0.1, kLongest = 2.5;  // way between the frames, in heights of the camera
  const double way = T_ref_cur.t.norm();
  if (!(way > 0)) return;
  choose_blocks(current, reference, kLevel, down_of(attitude), T_ref_cur, people);
  double all = 0;
  for (const Block& b : blocks_) all += voice(b);
  if (blocks_.empty()) return;
  constexpr double kFew = 24;  // a handful of blocks say little, however well they agree
  all = std::max(all, kFew);
  const int first = ScaleVotes::bin_of(kShortest * height_m / way),
            last = ScaleVotes::bin_of(kLongest * height_m / way);
  for (int bin = first; bin <= last; ++bin) {
    double most = 0;
    for (int p = 0; p < kPitches; ++p) {
      const double pitch = attitude.pitch_rad + 1.5 * pitch_sigma * (2.0 * p / (kPitches - 1) - 1);
      const Eigen::Vector3d m = down_of({pitch, attitude.roll_rad}) * (ScaleVotes::scale_of(bin) / height_m);
      compare_all(current, reference, kLevel, T_ref_cur, m);
      double sum = 0;
      for (const Block& b : blocks_)
        if (b.seen) sum += voice(b) * std::max(0.0f, 1 - b.squared / unlike(b));
      most = std::max(most, sum / all * std::exp(-0.5 * std::pow((pitch - attitude.pitch_rad) / pitch_sigma, 2)));
    }
    votes.add(bin, most);
  }
}

}  // namespace pavo
