// What can be seen in one frame, placed before its camera and sorted into the tiles of the image.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "drivers/synthetic/body.h"
#include "drivers/synthetic/part.h"
#include "drivers/synthetic/path.h"
#include "drivers/synthetic/street.h"
#include "drivers/synthetic/walkers.h"
#include "types/camera.h"

namespace pavo::synthetic {

/// The rays of a camera, computed once: where each pixel looks, in the plane z = 1.
class RayTable {
 public:
  explicit RayTable(const Camera& camera);
  const Camera& camera() const { return camera_; }
  /// Pixel (x, y), from -1 to the image's size inclusive; NaN where the lens sees nothing (or not in front).
  Eigen::Vector2f at(int x, int y) const {
    return rays_[static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(camera_.width + 2) +
                 static_cast<std::size_t>(x + 1)];
  }
  /// The same for any point, inside the image or beyond its edges; slow.
  Eigen::Vector2f look(double x, double y) const;
  /// The pixels that bounds of the ideal plane can reach, exact to a fraction of a pixel; not clipped to the image.
  void to_pixels(const Bounds& bounds, float& x0, float& y0, float& x1, float& y1) const;

 private:
  Camera camera_;
  std::vector<Eigen::Vector2f> rays_;
  float min_x_ = 0, min_y_ = 0, max_x_ = 0, max_y_ = 0;  ///< of the rays inside the image
};

/// A piece of the centre line, relative to the eye.
struct ViewPiece {
  Eigen::Vector2f start, start_along, end, end_along;  ///< x, z
  Eigen::Vector2f centre{0, 0};
  float curvature = 0, length = 0;
  double s = 0;         ///< of the start
  float texture_s = 0;  ///< the same, within the period of the ground's textures
};

/// The street's directions at one of its points.
struct Lane {
  Eigen::Vector2f along, right;
  float s = 0;        ///< since the piece's start
  float stretch = 1;  ///< metres along the centre line per metre here
};

/// Where a point of the ground lies in the street.
struct Located {
  int piece = -1;  ///< -1: off the street
  float l = 0;
};

/// A point, and how high above the road's height there it is.
struct Above {
  Located at;
  float height = 0;
};

struct VisiblePerson {
  int id = 0;
  bool companion = false;
  std::size_t first = 0, last = 0;  ///< of Scene::bodies
};

constexpr float kFarthest = 300;  ///< depth at which the ground becomes the sky
constexpr float kNever = 1e9F;    ///< depth of what is not met

struct Scene {
  static constexpr int kTile = 8;

  const Path* path = nullptr;
  Eigen::Vector3d eye{0, 0, 0};
  Eigen::Matrix3f R = Eigen::Matrix3f::Identity();  ///< camera to street
  std::vector<ViewPart> parts;                      ///< nearest first
  std::vector<float> light;                         ///< on those parts that are flat
  std::vector<ViewPiece> pieces;
  std::vector<GroundShade> shades;  ///< relative to the eye
  std::vector<VisiblePerson> people;
  std::vector<Part> bodies;
  int tiles_x = 0, tiles_y = 0;
  std::vector<std::vector<std::uint16_t>> tile_parts, tile_shades;  ///< per tile; shades by row of tiles

  std::size_t tile(int x, int y) const {
    return static_cast<std::size_t>(y / kTile) * static_cast<std::size_t>(tiles_x) +
           static_cast<std::size_t>(x / kTile);
  }
  /// The parts that a pixel can hit, nearest first; true where one of them is thin.
  bool parts_at(int x, int y, std::vector<std::uint16_t>& here) const {
    bool thin = false;
    here.clear();
    for (const std::uint16_t i : tile_parts[tile(x, y)]) {
      const ViewPart& view = parts[i];
      if (x < view.x0 || x > view.x1 || y < view.y0 || y > view.y1) continue;
      here.push_back(i);
      thin |= view.thin;
    }
    return thin;
  }
  Located locate(const Eigen::Vector2f& p, int hint) const;
  /// At a point that was located there; at.piece >= 0.
  Lane lane(const Located& at, const Eigen::Vector2f& p) const;
  /// Metres along the street; off it, those of the farthest end that is drawn.
  double s_of(const Located& at, const Eigen::Vector2f& p) const;
  /// Where the point of a ray from the eye at this depth is.
  Above above_road(const Eigen::Vector3f& ray, float t, int& hint) const;
  /// By how much a ray can come nearer to the ground per unit of depth, at most; where it is not positive, it never
  /// does.
  float descent(const Eigen::Vector3f& ray) const;
  /// At which depth, near `from`, a ray meets the surface `up` metres above the road's height; kNever: it does not.
  float depth_of_ground(const Eigen::Vector3f& ray, float up, float from, int& hint) const;
  /// The upright of the ground there, down, not normalised.
  Eigen::Vector3f ground_normal(const Located& at, const Eigen::Vector2f& p) const;
};

/// The world without a camera's moment: immutable, shared by all threads.
struct World {
  World(const SyntheticOptions& options, const Camera& camera);

  Drive drive;
  Street street;
  Walkers walkers;
  Wardrobe wardrobe;
  Eigen::Vector3f sun;
};

/// Fills the scene of a frame (its memory is used again).
void compose(const World& world, const RayTable& rays, int frame, Scene& scene);

/// Light that falls on a surface with this unit normal (street frame), 1 on open ground.
float light_on(const Eigen::Vector3f& normal, const Eigen::Vector3f& sun);

}  // namespace pavo::synthetic
