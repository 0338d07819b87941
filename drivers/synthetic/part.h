// The solids and surfaces that everything above the ground is made of, and rays against them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "drivers/synthetic/texture.h"

namespace pavo::synthetic {

constexpr float kNoHit = std::numeric_limits<float>::infinity();

enum class Shape : std::uint8_t {
  quad,        ///< local z = 0: x in [0, a], y in [0, b], and above its upper edge (y < 0) a gable of height c
  ellipsoid,   ///< the unit sphere of the local frame (which scales)
  round_cone,  ///< hull of two spheres: radius a at the local origin, radius b at (0, c, 0)
  foliage,     ///< an ellipsoid's front, with holes where its texture is darker than c; b: its texels a metre
  convex,      ///< a polyhedron
};

/// A side of a polyhedron: inside is normal . p <= offset. Its texture (or none) is laid on along two local axes.
struct Face {
  Eigen::Vector3f normal;
  float offset = 0;
  const Texture* texture = nullptr;
  Eigen::Vector3f u_axis = Eigen::Vector3f::Zero(), v_axis = Eigen::Vector3f::Zero();  ///< texels per metre
  float u0 = 0, v0 = 0;
  float albedo = 0.5F;
};
using Polyhedron = std::vector<Face>;

/// One piece of the scene. Points of the street become local by `to_local * (p - origin)`.
struct Part {
  Shape shape = Shape::quad;
  int person = -1;  ///< whose body this belongs to; -1: nobody's
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3f to_local = Eigen::Matrix3f::Identity();
  float a = 0, b = 0, c = 0;  ///< see Shape; polyhedra: they lie within [-a, a] x [-b, 0] x [-c, c]
  const Polyhedron* polyhedron = nullptr;
  /// Albedo is `albedo * (1 + contrast * (texel / 127.5 - 1))`.
  const Texture* texture = nullptr;
  float albedo = 0.5F, contrast = 1;
  float texels_u = 1, texels_v = 1;  ///< a metre (ellipsoids: a unit of the local frame)
  float u0 = 0, v0 = 0;              ///< texels
};

/// A dark, soft ellipse on the ground where something stands.
struct GroundShade {
  Eigen::Vector3d place{0, 0, 0};
  Eigen::Vector2d along{0, 1};  ///< unit
  float length = 1, width = 1;  ///< half axes, m
  float strength = 0.5F;        ///< in its middle, 0 to 1
};

/// A part as one camera sees it: rays start in the local point `o` and run along `B * (x, y, 1)`, t is the depth.
struct ViewPart {
  const Part* part = nullptr;
  Eigen::Matrix3f B = Eigen::Matrix3f::Identity();
  Eigen::Vector3f o = Eigen::Vector3f::Zero();
  float nearest = 0;                   ///< no hit is nearer than this depth
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< no pixel outside of [x0, x1] x [y0, y1] can hit it
  bool thin = false;  ///< so narrow that it may pass between the middles of pixels: all samples are needed
};

struct Bounds {  ///< of a projection, in the ideal image plane
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  float nearest = 0, farthest = 0;  ///< depths
  bool behind = false;              ///< nothing of it is in front of the camera
  bool unbounded = false;           ///< it reaches through the plane of the camera: the bounds are wide, but hold it
};

/// Places the part before a camera at `eye` that looks along R's third column.
ViewPart place(const Part& part, const Eigen::Vector3d& eye, const Eigen::Matrix3f& R);
/// The tight bounds of its projection (of polyhedra: of the box around them).
Bounds project(const ViewPart& view, const Eigen::Vector3d& eye, const Eigen::Matrix3f& R);

/// Depth at which the ray through (x, y) of the image plane enters the part (kNoHit: it does not). `face` is set for
/// polyhedra. `pixel` is the size of a pixel at depth 1.
float intersect(const ViewPart& view, float x, float y, float pixel, int& face);
/// Local normal (not normalised) at a local point of the surface of an ellipsoid or a round cone.
Eigen::Vector3f local_normal(const Part& part, const Eigen::Vector3f& p);
/// Foliage: the texture's coordinates at a point of the unit sphere.
Eigen::Vector2f leaf_coordinates(const Part& part, const Eigen::Vector3f& p);

}  // namespace pavo::synthetic
