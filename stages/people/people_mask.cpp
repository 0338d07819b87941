#include "stages/people/people_mask.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pavo {

bool in_outline(const PersonBox& person, float x, float y, const PeopleMaskOptions& options) {
  const float dx = std::abs(x - (person.x + person.width / 2)), half_x = person.width / 2 * options.width_factor;
  const float dy = std::abs(y - (person.y + person.height / 2)), half_y = person.height / 2 * options.height_factor;
  if (!(dx <= half_x && dy <= half_y)) return false;
  return !options.ellipse || dx * dx * half_y * half_y + dy * dy * half_x * half_x <= half_x * half_x * half_y * half_y;
}

std::size_t features_on_people(std::span<const Keypoint> keypoints, const People& people, std::span<std::uint8_t> keep,
                               const PeopleMaskOptions& options) {
  if (keep.size() != keypoints.size()) throw std::invalid_argument("people mask: one element of keep per keypoint");
  std::fill(keep.begin(), keep.end(), std::uint8_t{1});
  for (const PersonBox& person : people)
    for (std::size_t i = 0; i < keypoints.size(); ++i)
      if (in_outline(person, keypoints[i].x, keypoints[i].y, options)) keep[i] = 0;
  return static_cast<std::size_t>(std::count(keep.begin(), keep.end(), std::uint8_t{0}));
}

}  // namespace pavo
