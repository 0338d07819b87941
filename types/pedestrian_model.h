// The trained pedestrian classifier: how the features are made, and the plane that separates people from the rest.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace pavo {

/// How gray values become the numbers whose gradient is taken.
enum class HogTone {
  linear,
  square_root,  ///< Dalal and Triggs's gamma: a step counts more in the dark
};

/// The free parameters of the HOG (stages/people/hog.h): used with a classifier they must be those it was trained with.
struct HogOptions {
  HogTone tone = HogTone::square_root;
  /// Added to a block's norm before it is clipped, in gray levels of gradient summed over a cell; > 0.
  float epsilon = 100;
  /// L2-Hys: the largest share of a block's norm that one number may have; > 0.
  float clip = 0.2f;
  /// Added to the norm of the clipped block, before that is brought to 1; > 0. Weak blocks stay weak.
  float fade = 0.1f;
};

/// margin(window) = weights . HOG(window) + bias, and P(person | margin) = 1 / (1 + exp(-(slope margin + offset))).
struct PedestrianModel {
  static constexpr std::size_t kWeights = 3780;

  HogOptions features;
  std::vector<float> weights;  ///< kWeights, in the order of hog::descriptor_index()
  float bias = 0;
  double slope = 1, offset = 0;  ///< the calibration; slope > 0
  float threshold = 0.5f;        ///< the probability from which on a window counts as a person by default

  double probability(double margin) const { return 1 / (1 + std::exp(-(slope * margin + offset))); }
  /// The margin at which the probability is p; infinite at 0 and 1.
  double margin(double p) const {
    if (p <= 0) return -std::numeric_limits<double>::infinity();
    if (p >= 1) return std::numeric_limits<double>::infinity();
    return (std::log(p / (1 - p)) - offset) / slope;
  }
};

}  // namespace pavo
