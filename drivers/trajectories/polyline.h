// Lines on paper with no more points than the eye needs.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace pavo {

using Polyline = std::vector<Eigen::Vector2d>;

/// The points of a line of finite points that lie within `tolerance` of what is kept (Douglas and Peucker, 1973) left
/// out; the first and the last are kept. At most `most` (2 or more) points: the tolerance is doubled until they are.
Polyline thinned(const Polyline& line, double tolerance, std::size_t most);

/// 1, 2 or 5 times a power of ten: the smallest that is `at_least` (positive).
double round_step(double at_least);

}  // namespace pavo
