#include "drivers/synthetic/street.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "drivers/synthetic/layout.h"

namespace pavo::synthetic {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kLongest = 40;  ///< no thing is longer, along the street

Face face(const Vector3f& normal, const Vector3f& through, const Surface& surface, const Vector3f& u, float u0_m,
          const Vector3f& v, float v0_m) {
  Face f;
  f.normal = normal.normalized();
  f.offset = f.normal.dot(through);
  f.texture = &surface.texture;
  f.u_axis = u * surface.texels_u();
  f.v_axis = v * surface.texels_v();
  f.u0 = u0_m * surface.texels_u();
  f.v0 = v0_m * surface.texels_v();
  return f;
}

/// Local axes of a car: x ahead, y down, z right; it stands on y = 0.
Polyhedron car_body(const CarPaint& paint) {
  const Vector3f x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {face({0, 0, 1}, {0, 0, 0.87F}, paint.side, x, 2.15F, y, 0.92F),
          face({0, 0, -1}, {0, 0, -0.87F}, paint.side, x, 2.15F, y, 0.92F),
          face({1, -0.1F, 0}, {2.15F, -0.5F, 0}, paint.front, z, 0.87F, y, 0.92F),
          face({-1, -0.08F, 0}, {-2.15F, -0.5F, 0}, paint.rear, -z, 0.87F, y, 0.92F),
          face({0.12F, -1, 0}, {0.9F, -0.92F, 0}, paint.top, x, 1, z, 1),
          face({-0.05F, -1, 0}, {-1.4F, -0.93F, 0}, paint.top, x, 1, z, 1),
          face({0.7F, -0.7F, 0}, {2.1F, -0.7F, 0}, paint.top, x, 1, z, 1),
          face({0, 1, 0}, {0, -0.03F, 0}, paint.top, x, 1, z, 1)};
}

Polyhedron car_cabin(const CarPaint& paint) {
  const Vector3f x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {face({0, -0.27F, 1}, {0, -0.9F, 0.84F}, paint.glass_side, x, 1.7F, y, 1.43F),
          face({0, -0.27F, -1}, {0, -0.9F, -0.84F}, paint.glass_side, x, 1.7F, y, 1.43F),
          face({0.72F, -0.7F, 0}, {0.95F, -0.9F, 0}, paint.glass_end, z, 0.75F, y, 1.45F),
          face({-0.85F, -0.5F, 0}, {-1.8F, -0.9F, 0}, paint.glass_end, -z, 0.75F, y, 1.45F),
          face({0, -1, 0}, {0, -1.45F, 0}, paint.top, x, 1, z, 1),
          face({0, 1, 0}, {0, -0.85F, 0}, paint.top, x, 1, z, 1)};
}

}  // namespace

/// Puts things up along one side of the street.
class Street::Builder {
 public:
  Builder(Street& street, std::uint32_t seed, int side)
      : street_(street), seed_(seed), side_(side), random_(hash(seed, 41, static_cast<std::uint32_t>(side))) {}

  void houses() {
    const double end = street_.path_.end();
    for (double s = street_.path_.begin(); s < end - 6;) {
      const Facade& facade = next_facade();
      const double l = side_ * (kFacade + random_.uniform(0, 0.7F));
      const double far = chord_end(s, l, facade.front.width_m);
      if (street_.path_.loop() && far > end) {
        gap(s, end);
        break;
      }
      house(s, far, l, facade);
      s = far;
      const bool bends = std::abs(street_.path_.curvature(s) * side_) > 0.04;
      if (!bends && random_.chance(0.3F)) {
        const double next = s + random_.uniform(2.5F, 6);
        gap(s, next);
        s = next;
      }
    }
  }

  void furniture() {
    // NOLINTNEXTLINE(clang-analyzer-security.FloatLoopCounter): one place more or less at the far end is no error
    for (double s = street_.path_.begin() + 2; s < street_.path_.end() - 2; s += kParkingSlot) {
      // at the ends of parking places, so that nobody who crosses the street runs into a tree
      const double at = (std::floor(s / kParkingSlot)) * kParkingSlot;
      const int kind = random_.below(10);
      if (kind < 3) tree(at, side_ * kFurniture);
      if (kind == 4 || kind == 5) lamp(at, side_ * kFurniture);
      if (kind == 6) bin(at + 0.4, side_ * (kFurniture + 0.1));
      if (kind == 7) bollards(at, side_ * (kFurniture - 0.15));
      if (is_parked(seed_, street_.path_, at + kParkingSlot / 2, side_))
        car(at + kParkingSlot / 2 + random_.uniform(-0.5F, 0.5F));
    }
  }

 private:
  /// Each front comes once before any comes again; the two sides start at different ends, so that none faces itself.
  const Facade& next_facade() {
    const auto n = static_cast<int>(street_.surfaces_.facades.size());
    if (houses_ % (n / 2) == 0) jump_ = random_.below(n / 2);
    const int half = (houses_ / (n / 2) + (side_ > 0 ? 1 : 0)) & 1;
    const int k = (houses_++ + jump_) % (n / 2) + half * (n / 2);
    return street_.surfaces_.facades[static_cast<std::size_t>(k)];
  }

  Vector3d point(double s, double l, double up) const {
    const PathPoint p = street_.path_.at(s, l);
    return {p.x, -lift_ - up, p.z};
  }

  /// What stands on a slope does so as level as elsewhere, from its lowest place up.
  void begin(double s0, double s1) {
    thing_ = {s0, s1, street_.parts_.size(), 0, street_.shades_.size(), 0};
    lift_ = std::min(street_.path_.height(s0), street_.path_.height(s1));
  }
  void end() {
    thing_.parts = street_.parts_.size() - thing_.part;
    thing_.shades = street_.shades_.size() - thing_.shade;
    street_.things_.push_back(thing_);
  }

  /// The s at which a front of this width ends that starts at s.
  double chord_end(double s, double l, double width) const {
    const Vector3d from = point(s, l, 0);
    double far = s + 0.5 * width;
    while ((point(far, l, 0) - from).norm() < width && far < s + kLongest - 1) far += 0.05;
    return far;
  }

  /// A rectangle that hangs from `corner`: `a` metres along u, `b` along down, with a gable on top.
  void quad(const Vector3d& corner, const Vector3f& u, const Vector3f& down, float a, float b, float gable,
            const Surface& surface, float u0_m, float v0_m) {
    Part part;
    part.shape = Shape::quad;
    part.origin = corner;
    part.a = a;
    part.b = b;
    part.c = gable;
    part.to_local.row(0) = u;
    part.to_local.row(1) = down;
    part.to_local.row(2) = u.cross(down);
    part.texture = &surface.texture;
    part.texels_u = surface.texels_u();
    part.texels_v = surface.texels_v();
    part.u0 = u0_m * part.texels_u;
    part.v0 = v0_m * part.texels_v;
    street_.parts_.push_back(part);
  }

  void house(double s0, double s1, double l, const Facade& facade) {
    constexpr float kDeep = 9;
    begin(s0, s1);
    // as seen from the street, u runs from left to right: with s on the left side, against it on the right
    const Vector3d left = point(side_ > 0 ? s1 : s0, l, kKerbHeight),
                   right = point(side_ > 0 ? s0 : s1, l, kKerbHeight);
    const Vector3f u = (right - left).normalized().cast<float>(), down(0, 1, 0), back = u.cross(down);
    const float w = facade.front.width_m, h = facade.front.height_m, ridge = facade.pitched_roof ? 2.7F : 0.0F;
    const Vector3d top(0, -h, 0), front_left = left + top, front_right = left + w * u.cast<double>() + top;
    quad(front_left, u, down, w, h, 0, facade.front, 0, 0);
    const Surface& wall = street_.surfaces_.walls[static_cast<std::size_t>(facade.side)];
    for (const Vector3d& corner : {front_left, front_right})
      quad(corner, back, down, kDeep, h, ridge, wall, random_.uniform(0, 3), 15.9F - h);
    if (facade.pitched_roof) {
      const Vector3f slope = (Vector3f(0, ridge, 0) - back * (kDeep / 2)).normalized();
      const float length = std::hypot(ridge, kDeep / 2) + 0.35F;
      const Vector3d crest = front_left + (back * (kDeep / 2)).cast<double>() - Vector3d(0, ridge, 0);
      quad(crest, u, slope, w, length, 0, street_.surfaces_.roof, random_.uniform(0, 8), 0);
    }
    end();
  }

  /// A garden wall between two houses, and a tree behind it.
  void gap(double s0, double s1) {
    begin(s0, s1);
    const double l = side_ * (kFacade + 0.4);
    const Vector3d left = point(side_ > 0 ? s1 : s0, l, kKerbHeight + 1.7),
                   right = point(side_ > 0 ? s0 : s1, l, kKerbHeight + 1.7);
    const Vector3f u = (right - left).normalized().cast<float>();
    quad(left, u, {0, 1, 0}, static_cast<float>((right - left).norm()), 1.7F, 0,
         street_.surfaces_.walls[static_cast<std::size_t>(random_.below(4))], random_.uniform(0, 6), 14);
    end();
    tree((s0 + s1) / 2, l + side_ * 3.5);
  }

  void cone(const Vector3d& from, const Vector3d& to, float r_from, float r_to, float albedo,
            const Surface* surface = nullptr) {
    Part part;
    part.shape = Shape::round_cone;
    part.origin = from;
    part.a = r_from;
    part.b = r_to;
    const Vector3f y = (to - from).normalized().cast<float>();
    const Vector3f x = y.unitOrthogonal();
    part.c = static_cast<float>((to - from).norm());
    part.to_local.row(0) = x;
    part.to_local.row(1) = y;
    part.to_local.row(2) = x.cross(y);
    part.albedo = albedo;
    if (surface != nullptr) {
      part.texture = &surface->texture;
      part.texels_u = surface->texels_u();
      part.texels_v = surface->texels_v();
    } else {
      part.contrast = 0;
    }
    street_.parts_.push_back(part);
  }

  void shade(const Vector3d& place, double heading, float length, float width, float strength) {
    street_.shades_.push_back({place, {std::sin(heading), std::cos(heading)}, length, width, strength});
  }

  void tree(double s, double l) {
    begin(s - 3, s + 3);
    const float size = random_.uniform(0.85F, 1.25F);
    const Vector3d foot = point(s, l, kKerbHeight - 0.05),
                   fork = point(s + random_.uniform(-0.2F, 0.2F), l, 2.9 * size);
    cone(foot, fork, 0.17F * size, 0.1F * size, 0.24F, &street_.surfaces_.bark);
    cone(fork, point(s + 0.7, l + 0.3, 4.4 * size), 0.09F * size, 0.04F, 0.22F, &street_.surfaces_.bark);
    cone(fork, point(s - 0.6, l - 0.3, 4.3 * size), 0.09F * size, 0.04F, 0.22F, &street_.surfaces_.bark);
    const Vector3d heart = point(s, l, 4.7 * size);
    for (int i = 0; i < 26; ++i) {
      const float r = size * random_.uniform(0.4F, 0.9F), a = random_.uniform(0, 6.2832F), up = random_.uniform(-1, 1);
      const float out = std::sqrt(random_.uniform(0.15F, 1)) * size;
      const float ring = std::sqrt(1 - up * up);
      leaves(heart + (out * Vector3f(1.55F * ring * std::cos(a), 1.5F * up, 1.55F * ring * std::sin(a))).cast<double>(),
             r);
    }
    shade(foot, 0, 0.45F, 0.45F, 0.55F);
    shade(foot, 0, 2.2F * size, 2.2F * size, 0.28F);
    end();
  }

  void leaves(const Vector3d& centre, float radius) {
    const Surface& surface = street_.surfaces_.leaves;
    Part part;
    part.shape = Shape::foliage;
    part.origin = centre;
    part.to_local = Vector3f(1 / radius, 1.15F / radius, 1 / radius).asDiagonal();
    part.texture = &surface.texture;
    part.texels_u = radius * surface.texels_u();
    part.b = surface.texels_u();
    part.c = 40;
    part.u0 = random_.uniform(0, 4) * surface.texels_u();
    part.v0 = random_.uniform(1, 3) * surface.texels_v();
    street_.parts_.push_back(part);
  }

  void lamp(double s, double l) {
    begin(s - 2, s + 2);
    const Vector3d foot = point(s, l, 0.1), knee = point(s, l, 5.6), arm = point(s, l - side_ * 1.3, 6.2);
    cone(foot, point(s, l, 1.0), 0.1F, 0.09F, 0.25F, &street_.surfaces_.bark);
    cone(point(s, l, 1.0), knee, 0.065F, 0.05F, 0.3F);
    cone(knee, arm, 0.045F, 0.04F, 0.3F);
    cone(arm, point(s, l - side_ * 1.8, 6.2), 0.1F, 0.07F, 0.6F);
    shade(foot, 0, 0.25F, 0.25F, 0.5F);
    end();
  }

  void bin(double s, double l) {
    begin(s - 1, s + 1);
    const float tone = random_.uniform(0.12F, 0.5F);
    cone(point(s, l, 0.35), point(s, l, 0.95), 0.2F, 0.24F, tone, &street_.surfaces_.bark);
    cone(point(s, l, 1.08), point(s, l, 1.14), 0.17F, 0.14F, tone * 0.6F);
    shade(point(s, l, 0), 0, 0.4F, 0.4F, 0.6F);
    end();
  }

  void bollards(double s, double l) {
    begin(s - 3, s + 3);
    for (int i = -1; i <= 1; ++i) {
      const double at = s + 1.4 * i;
      cone(point(at, l, 0.1), point(at, l, 0.62), 0.07F, 0.065F, 0.13F);
      cone(point(at, l, 0.75), point(at, l, 0.82), 0.069F, 0.06F, 0.8F);
      cone(point(at, l, 0.9), point(at, l, 0.95), 0.066F, 0.05F, 0.13F);
    }
    end();
  }

  void car(double s) {
    begin(s - 3, s + 3);
    const double l = side_ * kParking;
    const double heading =
        street_.path_.at(s, l).heading + (side_ < 0 ? 3.14159265 : 0) + random_.uniform(-0.02F, 0.02F);
    const auto kind = static_cast<std::size_t>(random_.below(static_cast<int>(street_.car_bodies_.size())));
    Part part;
    part.shape = Shape::convex;
    part.origin = point(s, l, 0);
    const auto sn = static_cast<float>(std::sin(heading)), cs = static_cast<float>(std::cos(heading));
    part.to_local << sn, 0, cs, 0, 1, 0, cs, 0, -sn;  // rows: ahead, down, right
    part.a = 2.25F;
    part.b = 1.5F;
    part.c = 0.9F;
    part.polyhedron = &street_.car_bodies_[kind];
    street_.parts_.push_back(part);
    part.polyhedron = &street_.car_cabins_[kind];
    street_.parts_.push_back(part);
    shade(part.origin, heading, 2.5F, 1.15F, 0.85F);
    end();
  }

  Street& street_;
  std::uint32_t seed_;
  int side_;
  Random random_;
  Thing thing_;
  double lift_ = 0;  ///< of the ground under it
  int houses_ = 0, jump_ = 0;
};

Street::Street(const Path& path, std::uint32_t seed, float texel_m, int threads)
    : path_(path), surfaces_(paint_surfaces(seed, texel_m, threads)) {
  for (const CarPaint& paint : surfaces_.cars) {
    car_bodies_.push_back(car_body(paint));
    car_cabins_.push_back(car_cabin(paint));
  }
  for (const int side : {-1, 1}) {
    Builder builder(*this, seed, side);
    builder.houses();
    builder.furniture();
  }
  std::stable_sort(things_.begin(), things_.end(), [](const Thing& a, const Thing& b) { return a.s0 < b.s0; });
}

void Street::collect(double s0, double s1, std::vector<const Part*>& parts,
                     std::vector<const GroundShade*>& shades) const {
  const auto add = [&](const Thing& thing) {
    for (std::size_t i = 0; i < thing.parts; ++i) parts.push_back(&parts_[thing.part + i]);
    for (std::size_t i = 0; i < thing.shades; ++i) shades.push_back(&shades_[thing.shade + i]);
  };
  const auto between = [&](double from, double to) {
    auto thing = std::lower_bound(things_.begin(), things_.end(), from - kLongest,
                                  [](const Thing& a, double s) { return a.s0 < s; });
    for (; thing != things_.end() && thing->s0 < to; ++thing)
      if (thing->s1 > from) add(*thing);
  };
  const double from = path_.wrap(s0), to = from + (s1 - s0), end = path_.end();
  between(from, to);
  if (path_.loop() && to > end) between(path_.begin() - kLongest, path_.begin() + (to - end));
}

}  // namespace pavo::synthetic
