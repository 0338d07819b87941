// Which keypoints lie on a person, and must not be matched.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "stages/features/features.h"
#include "stages/people/people.h"

namespace pavo {

/// The outline that counts as the person: the box about its centre, times these factors. A box is 0.41 of its height
/// wide, whatever the person's arms and steps are: some need half of the height. Measured in docs/benchmarks.md.
struct PeopleMaskOptions {
  float width_factor = 1.25f;
  float height_factor = 1.0f;
  bool ellipse = false;  ///< the ellipse that has these for its axes: nobody fills the corners of a box
};

/// Whether a pixel lies inside the person's outline, its edge included.
bool in_outline(const PersonBox& person, float x, float y, const PeopleMaskOptions& options);

/// keep[i] = 0 where keypoint i lies inside somebody's outline (its edge included), 1 elsewhere; the number of zeros.
/// `keep` has one element per keypoint (else std::invalid_argument). Pure; allocates nothing.
std::size_t features_on_people(std::span<const Keypoint> keypoints, const People& people, std::span<std::uint8_t> keep,
                               const PeopleMaskOptions& options = {});

}  // namespace pavo
