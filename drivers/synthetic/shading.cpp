// How bright what a ray meets appears.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/synthetic/layout.h"
#include "drivers/synthetic/ray.h"
#include "drivers/synthetic/renderer.h"

namespace pavo::synthetic {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kHaze = 0.84F, kHazeLength = 230;

float hazy(float value, float depth) {
  const float clear = std::exp(-depth / kHazeLength);
  return kHaze + clear * (value - kHaze);
}

/// How a hit on a plane with this normal moves when the direction changes by dd.
Vector3f slide(const Vector3f& d, float t, const Vector3f& dd, const Vector3f& normal) {
  return t * dd - (t * dd.dot(normal) / d.dot(normal)) * d;
}

Vector2f flat(const Vector3f& p) {
  return {p.x(), p.z()};
}

/// How bright the ground is under what stands on it.
float open_to_the_sky(const Scene& scene, std::size_t tile, const Vector2f& p) {
  float light = 1;
  for (const std::uint16_t i : scene.tile_shades[tile]) {
    const GroundShade& shade = scene.shades[i];
    const Vector2f q = p - flat(shade.place.cast<float>()), along = shade.along.cast<float>();
    const float a = q.dot(along) / shade.length, b = (q.x() * along.y() - q.y() * along.x()) / shade.width;
    const float rest = 1 - (a * a * a * a + b * b * b * b) / 4;
    if (rest > 0) light *= 1 - shade.strength * rest * rest * rest;
  }
  return light;
}

/// What lies behind the houses: its texture is laid out in the world's x and z.
float sample_field(const Surface& field, const Eigen::Vector3d& eye, const Vector2f& p, const Vector2f& px,
                   const Vector2f& py) {
  const float k = field.texels_u(), size = field.width_m;
  const float x = static_cast<float>(std::fmod(eye.x(), size)) + p.x();
  const float z = static_cast<float>(std::fmod(eye.z(), size)) + p.y();
  const float v = (z - size * std::floor(z / size)) * k;  // only along u does a texture repeat by itself
  return field.texture.sample(x * k, v, {px.x() * k, px.y() * k, py.x() * k, py.y() * k}) / 255;
}

}  // namespace

float Renderer::shade(const Ray& ray, Hit hit, std::size_t tile, int& hint) const {
  if (hit.id == kSky) return shade_sky(ray);
  if (hit.id < kFirstPart) return shade_ground(ray, hit, tile, hint);
  return shade_part(ray, hit);
}

float Renderer::shade_sky(const Ray& ray) const {
  const auto& sky = world_.street.surfaces().sky;
  constexpr float kHalfPi = std::numbers::pi_v<float> / 2;
  const Vector3f d = ray.in(ray.scene->R).normalized();
  const float azimuth = std::atan2(d.x(), d.z()), below_zenith = kHalfPi + std::asin(std::min(d.y(), 0.0F));
  const float size = ray.pixel() * d.dot(ray.scene->R.col(2)) * sky.texels_u();
  return sky.texture.sample((azimuth + 2 * kHalfPi) * sky.texels_u(), below_zenith * sky.texels_v(), size) / 255;
}

float Renderer::shade_ground(const Ray& ray, Hit hit, std::size_t tile, int& hint) const {
  const Scene& scene = *ray.scene;
  const Surfaces& surfaces = world_.street.surfaces();
  const Vector3f d = ray.in(scene.R), dx = Ray::change(scene.R, ray.dx), dy = Ray::change(scene.R, ray.dy);
  const bool road = hit.id == kRoad, kerb = hit.id == kKerbFace;
  float t = hit.t;
  if (!kerb) {
    // This ray is some part of a pixel beside the one that was traced; over a crest it may miss what that met.
    const float beside = scene.depth_of_ground(d, road ? 0 : static_cast<float>(kKerbHeight), t, hint);
    if (beside < 1.2F * t) t = beside;
  }
  const Vector2f p(t * d.x(), t * d.z());
  const Located at = scene.locate(p, hint);
  Vector3f normal = scene.ground_normal(at, p);
  if (!(d.dot(normal) > 1e-5F)) normal = d;  // along the ground, on a crest
  const Vector2f px = flat(slide(d, t, dx, normal)), py = flat(slide(d, t, dy, normal));
  const float shadow = kerb ? 1 : open_to_the_sky(scene, tile, p);
  if (hit.id == kField || at.piece < 0) return hazy(shadow * sample_field(surfaces.field, scene.eye, p, px, py), t);

  const Lane lane = scene.lane(at, p);
  const Surface& surface = road ? surfaces.road : surfaces.sidewalk[at.l > 0];
  const float ku = surface.texels_u(), kv = surface.texels_v(),
              u = (lane.s + scene.pieces[static_cast<std::size_t>(at.piece)].texture_s) * ku;
  if (kerb) {  // the kerb stone's own texture, in the shade
    const Footprint footprint{t * ray.pixel() * ku, 0, 0, t * ray.pixel() * kv};
    return hazy(0.72F * surface.texture.sample(u, 0.08F * kv, footprint) / 255, t);
  }
  const float outwards = road || at.l > 0 ? 1.0F : -1.0F;
  const float v = (outwards * at.l + (road ? 1.0F : -1.0F) * static_cast<float>(kKerb)) * kv;
  const auto du = [&](const Vector2f& q) { return q.dot(lane.along) * lane.stretch * ku; };
  const auto dv = [&](const Vector2f& q) { return q.dot(lane.right) * outwards * kv; };
  return hazy(shadow * surface.texture.sample(u, v, {du(px), dv(px), du(py), dv(py)}) / 255, t);
}

float Renderer::shade_part(const Ray& ray, Hit hit) const {
  const Scene& scene = *ray.scene;
  const std::uint32_t index = part_of(hit.id);
  const ViewPart& view = scene.parts[index];
  const Part& part = *view.part;
  const Vector3f d = ray.in(view.B);
  float t = hit.t;
  if (part.shape == Shape::quad) {
    t = -view.o.z() / d.z();
    const Vector3f at = view.o + t * d;
    const Vector3f px = slide(d, t, Ray::change(view.B, ray.dx), Vector3f::UnitZ()),
                   py = slide(d, t, Ray::change(view.B, ray.dy), Vector3f::UnitZ());
    const float texel = part.texture->sample(
        at.x() * part.texels_u + part.u0, at.y() * part.texels_v + part.v0,
        {px.x() * part.texels_u, px.y() * part.texels_v, py.x() * part.texels_u, py.y() * part.texels_v});
    return hazy(scene.light[index] * texel / 255, t);
  }
  const Vector3f at = view.o + t * d;
  const float size = ray.pixel() * t;
  if (part.shape == Shape::convex) {
    const Face& face = (*part.polyhedron)[face_of(hit.id)];
    const Vector3f normal = part.to_local.transpose() * face.normal;
    const Vector3f dx = Ray::change(view.B, ray.dx), dy = Ray::change(view.B, ray.dy);
    const float slope = face.normal.dot(d);
    const Vector3f px = t * dx - (t * face.normal.dot(dx) / slope) * d,
                   py = t * dy - (t * face.normal.dot(dy) / slope) * d;
    const float texel =
        face.texture->sample(face.u_axis.dot(at) + face.u0, face.v_axis.dot(at) + face.v0,
                             {face.u_axis.dot(px), face.v_axis.dot(px), face.u_axis.dot(py), face.v_axis.dot(py)});
    return hazy(light_on(normal, world_.sun) * texel / 255, t);
  }
  const Vector3f normal = (part.to_local.transpose() * local_normal(part, at)).normalized();
  const float light = light_on(normal, world_.sun);
  if (part.shape == Shape::foliage) {
    const Vector2f uv = leaf_coordinates(part, at);
    return hazy((1.35F * light - 0.35F) * part.texture->sample(uv.x(), uv.y(), size * part.b) / 255, t);
  }
  float albedo = part.albedo;
  if (part.texture != nullptr && part.contrast > 0) {
    const float side = at.z() > 0 ? 41.0F : 0.0F;
    const float texel = part.texture->sample(at.x() * part.texels_u + part.u0 + side, at.y() * part.texels_v + part.v0,
                                             size * Wardrobe::kClothTexels);
    albedo *= 1 + part.contrast * (texel / 127.5F - 1);
  }
  return hazy(light * albedo, t);
}

}  // namespace pavo::synthetic
