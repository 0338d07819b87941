// From a margin to a probability, and from a rate of false alarms to a threshold.
#pragma once

#include <cstddef>
#include <span>

namespace pavo {

/// P(positive | margin) = 1 / (1 + exp(-(slope margin + offset)))
struct Sigmoid {
  double slope = 1, offset = 0;
};

/// Platt's scaling (1999) in the numerically safe form of Lin, Lin and Weng (Machine Learning, 2007): maximum
/// likelihood by Newton's method, with Platt's smoothed targets. Each positive counts `positive_weight`, which sets the
/// prior. Throws std::invalid_argument if either class is empty, or if the margins do not rise with the class.
Sigmoid fit_sigmoid(std::span<const double> positives, std::span<const double> negatives, double positive_weight);

/// The smallest margin at which no more than `allowed` of the `false_alarms` (margins, any order) are at or above it.
double threshold_for(std::span<const double> false_alarms, std::size_t allowed);

}  // namespace pavo
