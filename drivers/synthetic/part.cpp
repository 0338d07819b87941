#include "drivers/synthetic/part.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace pavo::synthetic {
namespace {

constexpr float kNearPlane = 0.15F;
constexpr float kWide = 1e4F;  ///< beyond all of the image plane that a lens shows

float intersect_quad(const Part& part, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  const float t = -o.z() / d.z();
  if (!(t > kNearPlane)) return kNoHit;
  const float u = o.x() + t * d.x(), v = o.y() + t * d.y();
  if (u < 0 || u > part.a || v > part.b) return kNoHit;
  if (v < 0 && -v > part.c * (1 - std::abs(2 * u / part.a - 1))) return kNoHit;
  return t;
}

/// The ray is first moved to the point nearest to the origin: far away, the squares would lose the small radius.
float intersect_sphere(const Eigen::Vector3f& o, const Eigen::Vector3f& d, float& leave) {
  const float dd = d.squaredNorm(), od = o.dot(d), room = dd * (o.squaredNorm() - 1);
  if (od * od < room - 1e-4F * std::abs(room)) return kNoHit;  // most rays, without a division
  const float middle = -od / dd;
  const float rest = 1 - (o + middle * d).squaredNorm();
  if (rest < 0) return kNoHit;
  const float half = std::sqrt(rest / dd);
  leave = middle + half;
  return middle - half > kNearPlane ? middle - half : kNoHit;
}

/// After Quilez' derivation for the hull of two spheres along the y axis.
float intersect_round_cone(const Part& part, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  const float reach = part.c / 2 + std::max(part.a, part.b), dd = d.squaredNorm();
  const Eigen::Vector3f from_middle(o.x(), o.y() - part.c / 2, o.z());
  const float od = from_middle.dot(d), room = dd * (from_middle.squaredNorm() - reach * reach);
  if (od * od < room - 1e-4F * std::abs(room)) return kNoHit;  // past the sphere around it: most rays
  const float inverse = 1 / std::sqrt(dd);
  const Eigen::Vector3f r = d * inverse;
  const float shift = -o.dot(r);
  const Eigen::Vector3f p = o + shift * r;
  const float ra = part.a, rb = part.b, h = part.c, pp = p.squaredNorm();
  const float rr = ra - rb, m0 = h * h, m1 = h * p.y(), m2 = h * r.y(), m3 = p.dot(r);
  const float d2 = m0 - rr * rr;
  const float k2 = d2 - m2 * m2, k1 = d2 * m3 - m1 * m2 + m2 * rr * ra;
  const float k0 = d2 * pp - m1 * m1 + m1 * rr * ra * 2 - m0 * ra * ra;
  const float disc = k1 * k1 - k0 * k2;
  if (disc < 0) return kNoHit;
  float t = (-std::sqrt(disc) - k1) / k2;
  const float y = m1 - ra * rr + t * m2;
  if (!(y > 0 && y < d2)) {
    t = kNoHit;
    const float qr = m3 - m2, qq = pp - 2 * m1 + m0;  // about the other sphere
    const float cap_a = m3 * m3 - pp + ra * ra, cap_b = qr * qr - qq + rb * rb;
    if (cap_a > 0) t = -m3 - std::sqrt(cap_a);
    if (cap_b > 0) t = std::min(t, -qr - std::sqrt(cap_b));
  }
  const float depth = (t + shift) * inverse;
  return depth > kNearPlane ? depth : kNoHit;
}

float intersect_convex(const Polyhedron& solid, const Eigen::Vector3f& o, const Eigen::Vector3f& d, int& face) {
  float enter = kNearPlane, leave = kNoHit;
  face = -1;
  for (std::size_t i = 0; i < solid.size(); ++i) {
    const float slope = solid[i].normal.dot(d), room = solid[i].offset - solid[i].normal.dot(o);
    if (slope < 0) {
      const float t = room / slope;
      if (t > enter) {
        enter = t;
        face = static_cast<int>(i);
      }
    } else if (slope > 0) {
      leave = std::min(leave, room / slope);
    } else if (room < 0) {
      return kNoHit;
    }
    if (enter >= leave) return kNoHit;
  }
  return face < 0 ? kNoHit : enter;
}

float intersect_foliage(const Part& part, const Eigen::Vector3f& o, const Eigen::Vector3f& d, float pixel) {
  float leave = 0;
  const float enter = intersect_sphere(o, d, leave);
  if (enter == kNoHit) return kNoHit;
  const Eigen::Vector2f uv = leaf_coordinates(part, o + enter * d);
  return part.texture->sample(uv.x(), uv.y(), pixel * enter * part.b) > part.c ? enter : kNoHit;
}

/// Bounds of an ellipsoid { c + M s : |s| <= 1 }: the planes through the camera that touch it.
Bounds bounds_of_ellipsoid(const Eigen::Vector3f& c, const Eigen::Matrix3f& M) {
  const Eigen::Matrix3f Q = M * M.transpose();
  const float deep = std::sqrt(Q(2, 2));
  Bounds b;
  b.nearest = c.z() - deep;
  b.farthest = c.z() + deep;
  b.behind = b.farthest <= kNearPlane;
  b.unbounded = b.nearest <= kNearPlane;
  if (b.unbounded) {  // what lies beside the camera is still only to be seen beside it
    const float wide = std::sqrt(Q(0, 0)), tall = std::sqrt(Q(1, 1)), far = std::max(b.farthest, kNearPlane);
    const auto side = [&](float from, float to, float& low, float& high) {
      low = from > 0 ? from / far : -kWide;
      high = to < 0 ? to / far : kWide;
    };
    side(c.x() - wide, c.x() + wide, b.x0, b.x1);
    side(c.y() - tall, c.y() + tall, b.y0, b.y1);
    return b;
  }
  const auto touch = [&](int i, float& low, float& high) {
    const float p = c.z() * c.z() - Q(2, 2), q = c(i) * c.z() - Q(i, 2), r = c(i) * c(i) - Q(i, i);
    const float root = std::sqrt(std::max(q * q - p * r, 0.0F));
    low = (q - root) / p;
    high = (q + root) / p;
  };
  touch(0, b.x0, b.x1);
  touch(1, b.y0, b.y1);
  return b;
}

Bounds merge(const Bounds& a, const Bounds& b) {
  Bounds both{std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
  both.nearest = std::min(a.nearest, b.nearest);
  both.farthest = std::max(a.farthest, b.farthest);
  both.behind = a.behind && b.behind;
  both.unbounded = a.unbounded || b.unbounded;
  return both;
}

/// Of a polygon, clipped at the near plane.
Bounds bounds_of_polygon(const std::array<Eigen::Vector3f, 5>& corners) {
  Bounds b{1e9F, 1e9F, -1e9F, -1e9F, 1e9F, -1e9F, true, false};
  const auto extend = [&](const Eigen::Vector3f& p) {
    const float x = p.x() / p.z(), y = p.y() / p.z();
    b = {std::min(b.x0, x),
         std::min(b.y0, y),
         std::max(b.x1, x),
         std::max(b.y1, y),
         std::min(b.nearest, p.z()),
         std::max(b.farthest, p.z()),
         false,
         false};
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3f &p = corners[i], &q = corners[(i + 1) % corners.size()];
    if (p.z() >= kNearPlane) extend(p);
    if ((p.z() >= kNearPlane) != (q.z() >= kNearPlane)) {
      Eigen::Vector3f cut = p + (kNearPlane - p.z()) / (q.z() - p.z()) * (q - p);
      cut.z() = kNearPlane;
      extend(cut);
    }
  }
  return b;
}

/// Of the box around a polyhedron.
Bounds bounds_of_box(const Eigen::Vector3f& c, const Eigen::Matrix3f& M, const Part& part) {
  const Eigen::Vector3f x = M.col(0) * part.a, y = M.col(1) * -part.b, z = M.col(2) * part.c;
  const auto face = [](const Eigen::Vector3f& corner, const Eigen::Vector3f& u, const Eigen::Vector3f& v) {
    return bounds_of_polygon({corner, corner + u, corner + u + v, corner + v, corner});
  };
  const Eigen::Vector3f low = c - x - z, high = c + x + z + y;
  Bounds all = merge(face(low, 2 * x, 2 * z), face(low, 2 * x, y));
  all = merge(all, face(low, 2 * z, y));
  all = merge(all, face(high, -2 * x, -2 * z));
  all = merge(all, face(high, -2 * x, -y));
  return merge(all, face(high, -2 * z, -y));
}

}  // namespace

Eigen::Vector2f leaf_coordinates(const Part& part, const Eigen::Vector3f& p) {
  const Eigen::Vector3f a = p.cwiseAbs();
  const Eigen::Vector3f q = p * part.texels_u;
  if (a.z() >= a.x() && a.z() >= a.y()) return {q.x() + part.u0, q.y() + part.v0 + (p.z() > 0 ? 0.0F : 77.0F)};
  if (a.x() >= a.y()) return {q.z() + part.u0 + 31, q.y() + part.v0 + (p.x() > 0 ? 0.0F : 77.0F)};
  return {q.x() + part.u0 + 59, q.z() + part.v0 + (p.y() > 0 ? 0.0F : 77.0F)};
}

ViewPart place(const Part& part, const Eigen::Vector3d& eye, const Eigen::Matrix3f& R) {
  ViewPart view;
  view.part = &part;
  view.B = part.to_local * R;
  view.o = part.to_local * (eye - part.origin).cast<float>();
  return view;
}

Bounds project(const ViewPart& view, const Eigen::Vector3d& eye, const Eigen::Matrix3f& R) {
  const Part& part = *view.part;
  const Eigen::Vector3f c = R.transpose() * (part.origin - eye).cast<float>();
  const Eigen::Matrix3f M = view.B.inverse();  // local to camera
  if (part.shape == Shape::convex) return bounds_of_box(c, M, part);
  switch (part.shape) {
    case Shape::quad: {
      const Eigen::Vector3f u = M.col(0) * part.a, v = M.col(1) * part.b, up = M.col(1) * -part.c;
      return bounds_of_polygon({c, c + 0.5F * u + up, c + u, c + u + v, c + v});
    }
    case Shape::round_cone:
      return merge(bounds_of_ellipsoid(c, M * part.a), bounds_of_ellipsoid(c + M.col(1) * part.c, M * part.b));
    default:
      return bounds_of_ellipsoid(c, M);
  }
}

float intersect(const ViewPart& view, float x, float y, float pixel, int& face) {
  const Eigen::Vector3f d = view.B.col(0) * x + view.B.col(1) * y + view.B.col(2);
  face = 0;
  switch (view.part->shape) {
    case Shape::quad:
      return intersect_quad(*view.part, view.o, d);
    case Shape::round_cone:
      return intersect_round_cone(*view.part, view.o, d);
    case Shape::foliage:
      return intersect_foliage(*view.part, view.o, d, pixel);
    case Shape::convex:
      return intersect_convex(*view.part->polyhedron, view.o, d, face);
    case Shape::ellipsoid:
      break;
  }
  float leave = 0;
  return intersect_sphere(view.o, d, leave);
}

Eigen::Vector3f local_normal(const Part& part, const Eigen::Vector3f& p) {
  if (part.shape != Shape::round_cone) return p;
  const float rr = part.a - part.b, d2 = part.c * part.c - rr * rr, y = part.c * p.y() - part.a * rr;
  if (y <= 0) return p;
  if (y >= d2) return p - Eigen::Vector3f(0, part.c, 0);
  return d2 * p - Eigen::Vector3f(0, part.c * y, 0);
}

}  // namespace pavo::synthetic
