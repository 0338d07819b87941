// Comparing a block of the current image with what the reference image shows of it.
#pragma once

#include <Eigen/Core>

#include "stages/ground/align_ground.h"
#include "stages/ground/ground_image.h"

namespace pavo {

struct BlockSize {
  int width, height;
};

constexpr BlockSize block_size(int level) {
  return level == 0 ? BlockSize{32, 8} : level == 1 ? BlockSize{16, 8} : BlockSize{8, 4};
}

/// Fills in the sums of its gray values and gradients.
void measure_texture(const GroundImage::Level& image, BlockSize size, AlignGround::Block& block);

/// Fills in the sums of the differences to the reference image through the homography H (pixels of this level to
/// pixels of this level). False where that leaves the reference image.
bool compare_block(const GroundImage::Level& current, const GroundImage::Level& reference, BlockSize size,
                   const Eigen::Matrix3d& H, AlignGround::Block& block);

}  // namespace pavo
