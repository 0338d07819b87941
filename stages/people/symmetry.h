// A classifier that judges a picture and its mirror image alike.
#pragma once

#include <span>
#include <vector>

namespace pavo {

/// Weights and, last, the bias of a classifier whose margin is the mean of this one's margins of a window and of its
/// mirror image. People are as often turned left as right, and the positives of a training are mirrored for that; its
/// negatives are not (every one of them would cost as much again), and what they have left and right by chance cancels
/// here. Throws std::invalid_argument unless there are kDescriptorSize + 1 numbers.
std::vector<double> symmetric(std::span<const double> weights_and_bias);

}  // namespace pavo
