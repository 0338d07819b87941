#include "drivers/synthetic/body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "drivers/synthetic/canvas.h"

namespace pavo::synthetic {
namespace {

using Eigen::Vector3f;

struct Material {
  float albedo = 0.5F;
  const Texture* texture = nullptr;
  float contrast = 0;
};

/// Puts limbs together in the body's frame: x to its right, y down, z ahead, the origin on the ground between its feet.
class Sculptor {
 public:
  Sculptor(const Stride& stride, int person, std::vector<Part>& parts)
      : origin_(stride.feet), person_(person), parts_(parts) {
    const auto c = static_cast<float>(std::cos(stride.heading)), s = static_cast<float>(std::sin(stride.heading));
    to_body_ << c, 0, -s, 0, 1, 0, s, 0, c;  // rows: right, down, ahead
  }

  /// flat < 1: less deep (along `ahead`) than wide.
  void cone(const Vector3f& from, const Vector3f& to, float r_from, float r_to, const Material& m, float flat = 1) {
    Part part = make(Shape::round_cone, from, m);
    const Vector3f along = to - from;
    part.c = std::max(along.norm(), std::abs(r_from - r_to) + 1e-3F);
    part.a = r_from;
    part.b = r_to;
    const Vector3f y = along.normalized();
    const Vector3f ahead = std::abs(y.z()) < 0.95F ? Vector3f(0, 0, 1) : Vector3f(0, 1, 0);
    const Vector3f x = y.cross(ahead).normalized(), z = x.cross(y);
    part.to_local.row(0) = x;
    part.to_local.row(1) = y;
    part.to_local.row(2) = z / flat;
    part.to_local = part.to_local * to_body_;
    parts_.push_back(part);
  }

  void ellipsoid(const Vector3f& centre, const Vector3f& half_axes, const Material& m) {
    Part part = make(Shape::ellipsoid, centre, m);
    part.to_local = half_axes.cwiseInverse().asDiagonal() * to_body_;
    part.texels_u *= half_axes.x();
    part.texels_v *= half_axes.y();
    parts_.push_back(part);
  }

 private:
  Part make(Shape shape, const Vector3f& at, const Material& m) const {
    Part part;
    part.shape = shape;
    part.person = person_;
    part.origin = origin_ + (to_body_.transpose() * at).cast<double>();
    part.albedo = m.albedo;
    part.texture = m.texture;
    part.contrast = m.contrast;
    part.texels_u = part.texels_v = Wardrobe::kClothTexels;
    part.u0 = static_cast<float>(parts_.size() * 37 % 128);
    part.v0 = static_cast<float>(parts_.size() * 53 % 60) + 40;
    return part;
  }

  Eigen::Vector3d origin_;
  Eigen::Matrix3f to_body_;
  int person_;
  std::vector<Part>& parts_;
};

struct Leg {
  Vector3f hip, knee, ankle, toe;
};

/// The joints of a leg in its phase, hanging from a hip at height 0. Angles after the sagittal kinematics of normal
/// gait.
Leg leg_at(double phase, float amplitude, float side, float h) {
  const auto swing = static_cast<float>(std::sin(phase));
  const auto lift = static_cast<float>(std::max(0.0, std::cos(phase + 0.35)));
  const float thigh = 0.05F + amplitude * swing, flexion = 0.08F + 2.1F * amplitude * lift * lift;
  const float shin = thigh - flexion, foot = 0.55F * shin + 0.08F;
  Leg leg;
  leg.hip = Vector3f(side * 0.052F * h, 0, 0);
  leg.knee = leg.hip + 0.245F * h * Vector3f(-0.02F * side, std::cos(thigh), std::sin(thigh));
  leg.ankle = leg.knee + 0.24F * h * Vector3f(-0.02F * side, std::cos(shin), std::sin(shin));
  leg.toe = leg.ankle + 0.1F * h * Vector3f(0.12F * side, 0.26F - std::sin(foot), std::cos(foot));
  return leg;
}

void move(Leg& leg, float down) {
  for (Vector3f* p : {&leg.hip, &leg.knee, &leg.ankle, &leg.toe}) p->y() += down;
}

void build_leg(const Leg& leg, const Look& look, const Material& cloth, Sculptor& sculptor) {
  const float h = look.height_m, g = look.girth;
  const Material shoe{look.shoes, nullptr, 0}, skin{look.skin, nullptr, 0};
  const Material& calf = look.skirt ? skin : cloth;
  sculptor.cone(leg.hip, leg.knee, 0.05F * h * g, 0.034F * h * g, cloth);
  sculptor.cone(leg.knee, leg.ankle, 0.034F * h * g, 0.026F * h * g, calf);
  const Vector3f heel = leg.ankle + Vector3f(0, 0.012F * h, -0.018F * h);
  sculptor.cone(heel, leg.toe, 0.024F * h, 0.019F * h, shoe);
}

void build_arm(double phase, float amplitude, float side, float shoulder_y, const Look& look, const Material& cloth,
               Sculptor& sculptor) {
  const float h = look.height_m, g = look.girth;
  const Material skin{look.skin, nullptr, 0};
  const float upper = -0.02F + 0.75F * amplitude * static_cast<float>(std::sin(phase));
  const float fore = upper + 0.25F + 0.5F * amplitude * (1 + static_cast<float>(std::sin(phase)));
  const Vector3f shoulder(side * 0.104F * h * g, shoulder_y, 0);
  const Vector3f elbow = shoulder + 0.17F * h * Vector3f(0.14F * side, std::cos(upper), std::sin(upper));
  const Vector3f wrist = elbow + 0.15F * h * Vector3f(-0.02F * side, std::cos(fore), std::sin(fore));
  const Vector3f hand = wrist + 0.05F * h * Vector3f(0, std::cos(fore), std::sin(fore));
  sculptor.cone(shoulder, elbow, 0.033F * h * g, 0.026F * h * g, cloth);
  sculptor.cone(elbow, wrist, 0.0255F * h * g, 0.019F * h * g, look.short_sleeves ? skin : cloth);
  sculptor.cone(wrist, hand, 0.017F * h, 0.015F * h, skin);
  if (look.handbag && side > 0)
    sculptor.ellipsoid(hand + Vector3f(0, 0.09F * h, 0), Vector3f(0.03F, 0.075F, 0.09F) * h, {look.bag, nullptr, 0});
}

void build_head(const Look& look, float chin_y, Sculptor& sculptor) {
  const float h = look.height_m;
  const Material skin{look.skin, nullptr, 0}, hair{look.hair, nullptr, 0};
  const float middle = chin_y - 0.062F * h;
  sculptor.cone({0, chin_y + 0.035F * h, -0.006F * h}, {0, chin_y - 0.02F * h, 0}, 0.034F * h, 0.031F * h, skin);
  sculptor.ellipsoid({0, middle, 0.006F * h}, Vector3f(0.046F, 0.068F, 0.055F) * h, skin);
  sculptor.ellipsoid({0, middle - 0.014F * h, -0.02F * h}, Vector3f(0.05F, 0.059F, 0.049F) * h, hair);
  if (look.long_hair)
    sculptor.cone({0, middle, -0.03F * h}, {0, chin_y + 0.05F * h, -0.035F * h}, 0.044F * h, 0.04F * h, hair, 0.7F);
  if (look.hat)
    sculptor.ellipsoid({0, middle - 0.045F * h, 0}, Vector3f(0.055F, 0.036F, 0.062F) * h, {look.bag, nullptr, 0});
}

void build_trunk(const Look& look, float hip_y, float shoulder_y, const Material& top, const Material& legs,
                 Sculptor& sculptor) {
  const float h = look.height_m, g = look.girth;
  const Vector3f chest(0, shoulder_y + 0.075F * h, 0), waist(0, hip_y - 0.07F * h, 0),
      seat(0, hip_y - 0.005F * h, -0.005F * h);
  sculptor.cone(chest, waist, 0.099F * h * g, 0.086F * h * g, top, 0.66F);
  sculptor.cone({-0.075F * h * g, shoulder_y + 0.012F * h, 0}, {0.075F * h * g, shoulder_y + 0.012F * h, 0},
                0.042F * h * g, 0.0419F * h * g, top);
  sculptor.cone(waist, seat, 0.084F * h * g, 0.088F * h * g, look.coat ? top : legs, 0.74F);
  if (look.coat) sculptor.cone(waist, {0, hip_y + 0.17F * h, 0}, 0.086F * h * g, 0.104F * h * g, top, 0.78F);
  if (look.skirt) sculptor.cone(seat, {0, hip_y + 0.17F * h, 0}, 0.086F * h * g, 0.1F * h * g, legs, 0.85F);
  if (look.backpack)
    sculptor.ellipsoid({0, shoulder_y + 0.13F * h, -0.1F * h}, Vector3f(0.085F, 0.13F, 0.06F) * h,
                       {look.bag, nullptr, 0});
}

}  // namespace

Look::Look(std::uint32_t seed) {
  Random r(hash(seed, 71));
  height_m = r.uniform(1.6F, 1.9F);
  girth = r.uniform(0.94F, 1.14F);
  skin = r.chance(0.3F) ? r.uniform(0.22F, 0.35F) : r.uniform(0.45F, 0.62F);
  hair = r.chance(0.25F) ? r.uniform(0.3F, 0.5F) : r.uniform(0.06F, 0.16F);
  top = r.chance(0.55F) ? r.uniform(0.07F, 0.2F) : r.uniform(0.4F, 0.85F);
  legs = r.chance(0.75F) ? r.uniform(0.06F, 0.2F) : r.uniform(0.35F, 0.6F);
  shoes = r.chance(0.7F) ? r.uniform(0.04F, 0.12F) : r.uniform(0.5F, 0.8F);
  bag = r.uniform(0.06F, 0.5F);
  top_cloth = r.below(1000);
  legs_cloth = r.chance(0.8F) ? 0 : 1;
  long_hair = r.chance(0.4F);
  hat = r.chance(0.15F);
  skirt = r.chance(0.15F);
  coat = !skirt && r.chance(0.25F);
  short_sleeves = !coat && r.chance(0.3F);
  backpack = r.chance(0.25F);
  handbag = !backpack && r.chance(0.25F);
  top_contrast = r.uniform(0.35F, 0.8F);
}

double stride_length(double speed_mps) {
  return 0.62 + 0.58 * speed_mps;
}

void build_body(const Look& look, const Stride& stride, int person, const Wardrobe& wardrobe,
                std::vector<Part>& parts) {
  Sculptor sculptor(stride, person, parts);
  const float h = look.height_m;
  const auto amplitude = static_cast<float>(0.15 + 0.13 * std::min(stride.speed_mps, 2.0));
  Leg left = leg_at(stride.phase, amplitude, -1, h), right = leg_at(stride.phase + 3.14159265, amplitude, 1, h);
  // the lower foot stands on the ground
  const float lowest = std::max({left.ankle.y() + 0.036F * h, right.ankle.y() + 0.036F * h, left.toe.y() + 0.019F * h,
                                 right.toe.y() + 0.019F * h});
  move(left, -lowest);
  move(right, -lowest);
  const float hip_y = left.hip.y(), shoulder_y = hip_y - 0.3F * h, chin_y = shoulder_y - 0.052F * h;

  const auto cloth = [&](int i) { return &wardrobe.cloths[static_cast<std::size_t>(i) % wardrobe.cloths.size()]; };
  const Material top{look.top, cloth(look.top_cloth), look.top_contrast}, legs{look.legs, cloth(look.legs_cloth), 0.5F};
  build_leg(left, look, legs, sculptor);
  build_leg(right, look, legs, sculptor);
  build_trunk(look, hip_y, shoulder_y, top, legs, sculptor);
  build_arm(stride.phase + 3.14159265, amplitude, -1, shoulder_y + 0.018F * h, look, top, sculptor);
  build_arm(stride.phase, amplitude, 1, shoulder_y + 0.018F * h, look, top, sculptor);
  build_head(look, chin_y, sculptor);
}

Wardrobe make_wardrobe(std::uint32_t seed) {
  constexpr int kSize = 128;
  constexpr float kMetres = kSize / Wardrobe::kClothTexels;
  const Noise noise(hash(seed, 72));
  Random r(hash(seed, 73));
  Wardrobe wardrobe;
  for (int kind = 0; kind < 8; ++kind) {
    Canvas canvas(kMetres, 2 * kMetres, kSize, 2 * kSize, true);
    canvas.fill([&](float x, float y) {
      float v = 0.5F + 0.16F * noise.fractal(x * 9 + 40 * static_cast<float>(kind), y * 5, 4);  // folds, and the weave
      if (kind == 2) v += std::sin(y * 130) > 0.2F ? 0.25F : -0.2F;                             // stripes across
      if (kind == 3) v += (std::sin(x * 70) > 0.3F ? 0.16F : -0.08F) + (std::sin(y * 70) > 0.3F ? 0.16F : -0.08F);
      if (kind == 4) v += y < 0.42F * kMetres ? 0.25F : -0.22F;    // two halves
      if (kind == 5) v += std::sin(x * 90) > 0.6F ? 0.3F : -0.1F;  // pinstripes
      return v;
    });
    if (kind == 6)
      for (int i = 0; i < 60; ++i)
        canvas.disc(r.uniform(0, kMetres), r.uniform(0, 2 * kMetres), 0.018F, r.unit(), 0.8F);
    if (kind == 7)
      for (int i = 0; i < 8; ++i)
        canvas.lettering(r.uniform(0, kMetres), 0.12F * static_cast<float>(i) + 0.05F, 0.05F, 6,
                         r.chance(0.5F) ? 0.95F : 0.1F, r);
    wardrobe.cloths.push_back(canvas.texture());
  }
  return wardrobe;
}

}  // namespace pavo::synthetic
