#include "drivers/synthetic/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/synthetic/layout.h"
#include "types/lens.h"

namespace pavo::synthetic {
namespace {

constexpr double kBehind = 12, kAhead = 170;  ///< metres of street that are drawn
constexpr float kSteepest = 12;               ///< rays farther from the axis than this (85 degrees) see nothing

std::uint32_t fold(std::uint64_t seed) {
  return hash(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
}

void add_pieces(const Path& path, double s, const Eigen::Vector3d& eye, std::vector<ViewPiece>& pieces) {
  const Eigen::Vector2d at(eye.x(), eye.z());
  const double here = path.wrap(s), round = path.end() - path.begin();
  for (const PathPiece& p : path.pieces()) {
    const auto in_view = [&](double shift) {
      return p.s + shift < here + kAhead && p.s + shift + p.length > here - kBehind;
    };
    if (!in_view(0) && !(path.loop() && (in_view(round) || in_view(-round)))) continue;
    ViewPiece v;
    const double turn = p.curvature * p.length;
    const PathPoint end = path.at(std::nextafter(p.s + p.length, p.s), 0);
    const Eigen::Vector2d along(std::sin(p.heading), std::cos(p.heading)),
        right(std::cos(p.heading), -std::sin(p.heading));
    v.start = (Eigen::Vector2d(p.x, p.z) - at).cast<float>();
    v.end = (Eigen::Vector2d(end.x, end.z) - at).cast<float>();
    v.start_along = along.cast<float>();
    v.end_along = Eigen::Vector2d(std::sin(p.heading + turn), std::cos(p.heading + turn)).cast<float>();
    v.curvature = static_cast<float>(p.curvature);
    v.length = static_cast<float>(p.length);
    if (p.curvature != 0) v.centre = (Eigen::Vector2d(p.x, p.z) + right / p.curvature - at).cast<float>();
    v.s = p.s;
    v.texture_s = static_cast<float>(std::fmod(p.s + 100 * kGroundPeriod, kGroundPeriod));
    pieces.push_back(v);
  }
}

void add_people(const World& world, int frame, Scene& scene) {
  for (const Walker& walker : world.walkers.all()) {
    Stride stride;
    if (!world.walkers.stride(walker, frame, world.drive, stride)) continue;
    VisiblePerson person{walker.id, walker.companion, scene.bodies.size(), 0};
    const Look look(walker.look_seed);
    build_body(look, stride, static_cast<int>(scene.people.size()), world.wardrobe, scene.bodies);
    person.last = scene.bodies.size();
    scene.people.push_back(person);
    scene.shades.push_back({stride.feet, {0, 1}, 0.3F, 0.3F, 0.55F});
  }
}

/// Measures a part's picture; false: it is not in the image.
bool frame_part(const RayTable& rays, const Scene& scene, ViewPart& view) {
  const Bounds bounds = project(view, scene.eye, scene.R);
  if (bounds.behind || bounds.nearest > kAhead) return false;
  const Camera& camera = rays.camera();
  view.nearest = bounds.nearest;
  float x0, y0, x1, y1;
  rays.to_pixels(bounds, x0, y0, x1, y1);
  if (x1 < -1 || y1 < -1 || x0 > static_cast<float>(camera.width) || y0 > static_cast<float>(camera.height))
    return false;
  // a sample lies up to half a pixel beside its pixel's centre
  const auto clip = [](float v, int size) {
    return static_cast<int>(std::clamp(v, 0.0F, static_cast<float>(size - 1)));
  };
  view.x0 = clip(std::floor(x0) - 1, camera.width);
  view.y0 = clip(std::floor(y0) - 1, camera.height);
  view.x1 = clip(std::ceil(x1) + 1, camera.width);
  view.y1 = clip(std::ceil(y1) + 1, camera.height);
  const auto fx = static_cast<float>(camera.fx);
  constexpr float kThin = 1.5F;  // pixels: what is wider is met by the middle of some pixel beside each of its own
  const bool slender =
      view.part->shape == Shape::round_cone && 2 * std::max(view.part->a, view.part->b) * fx < kThin * bounds.nearest;
  view.thin = slender || std::min(x1 - x0, y1 - y0) < kThin;
  return true;
}

void sort_into_tiles(const Camera& camera, Scene& scene) {
  scene.tiles_x = (camera.width + Scene::kTile - 1) / Scene::kTile;
  scene.tiles_y = (camera.height + Scene::kTile - 1) / Scene::kTile;
  const auto count = static_cast<std::size_t>(scene.tiles_x) * static_cast<std::size_t>(scene.tiles_y);
  scene.tile_parts.resize(count);
  for (auto& list : scene.tile_parts) list.clear();
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    const ViewPart& v = scene.parts[i];
    for (int y = v.y0 / Scene::kTile; y <= v.y1 / Scene::kTile; ++y)
      for (int x = v.x0 / Scene::kTile; x <= v.x1 / Scene::kTile; ++x)
        scene
            .tile_parts[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene.tiles_x) +
                        static_cast<std::size_t>(x)]
            .push_back(static_cast<std::uint16_t>(i));
  }
}

/// Which dark spots of the ground can be seen in which tiles.
void sort_shades(const RayTable& rays, Scene& scene) {
  scene.tile_shades.resize(scene.tile_parts.size());
  for (auto& list : scene.tile_shades) list.clear();
  for (std::size_t i = 0; i < scene.shades.size(); ++i) {
    GroundShade& shade = scene.shades[i];
    shade.place -= scene.eye;
    const float reach = 1.5F * std::max(shade.length, shade.width);
    Part disc;
    disc.shape = Shape::ellipsoid;
    disc.origin = scene.eye + shade.place;
    const float slack = 0.2F + static_cast<float>(scene.path->steepest()) * (reach + 3);  // it stands level
    disc.to_local = Eigen::Vector3f(1 / reach, 1 / slack, 1 / reach).asDiagonal();
    ViewPart view = place(disc, scene.eye, scene.R);
    if (!frame_part(rays, scene, view)) continue;
    for (int y = view.y0 / Scene::kTile; y <= view.y1 / Scene::kTile; ++y)
      for (int x = view.x0 / Scene::kTile; x <= view.x1 / Scene::kTile; ++x)
        scene
            .tile_shades[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene.tiles_x) +
                         static_cast<std::size_t>(x)]
            .push_back(static_cast<std::uint16_t>(i));
  }
}

}  // namespace

RayTable::RayTable(const Camera& camera) : camera_(camera) {
  rays_.reserve(static_cast<std::size_t>(camera.width + 2) * static_cast<std::size_t>(camera.height + 2));
  min_x_ = min_y_ = 1e9F;
  max_x_ = max_y_ = -1e9F;
  for (int y = -1; y <= camera.height; ++y) {
    for (int x = -1; x <= camera.width; ++x) {
      const Eigen::Vector2f ray = look(x, y);
      rays_.push_back(ray);
      if (!(std::abs(ray.x()) < kSteepest)) continue;
      min_x_ = std::min(min_x_, ray.x());
      max_x_ = std::max(max_x_, ray.x());
      min_y_ = std::min(min_y_, ray.y());
      max_y_ = std::max(max_y_, ray.y());
    }
  }
}

Eigen::Vector2f RayTable::look(double x, double y) const {
  constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
  const auto ray = unproject(camera_, {x, y});
  if (!ray || ray->z() * kSteepest < ray->head<2>().norm()) return {kNothing, kNothing};
  return (ray->head<2>() / ray->z()).cast<float>();
}

void RayTable::to_pixels(const Bounds& b, float& x0, float& y0, float& x1, float& y1) const {
  const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
  const auto cx = static_cast<float>(camera_.cx), cy = static_cast<float>(camera_.cy);
  if (camera_.lens == Lens::rectified) {
    x0 = fx * b.x0 + cx;
    x1 = fx * b.x1 + cx;
    y0 = fy * b.y0 + cy;
    y1 = fy * b.y1 + cy;
    return;
  }
  // along the outline, where it can be seen: beyond the field of view the formula may turn back
  const auto in_x = [&](float v) { return std::clamp(v, min_x_, max_x_); };
  const auto in_y = [&](float v) { return std::clamp(v, min_y_, max_y_); };
  x0 = y0 = 1e9F;
  x1 = y1 = -1e9F;
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i) {
    const float a = static_cast<float>(i) / kSteps;
    const float x = in_x(b.x0) + a * (in_x(b.x1) - in_x(b.x0)), y = in_y(b.y0) + a * (in_y(b.y1) - in_y(b.y0));
    for (const auto& p : {Eigen::Vector2f(x, in_y(b.y0)), Eigen::Vector2f(x, in_y(b.y1)),
                          Eigen::Vector2f(in_x(b.x0), y), Eigen::Vector2f(in_x(b.x1), y)}) {
      const Eigen::Vector2f q = distort(camera_, p.cast<double>()).cast<float>();
      x0 = std::min(x0, fx * q.x() + cx);
      x1 = std::max(x1, fx * q.x() + cx);
      y0 = std::min(y0, fy * q.y() + cy);
      y1 = std::max(y1, fy * q.y() + cy);
    }
  }
}

Located Scene::locate(const Eigen::Vector2f& p, int hint) const {
  constexpr float kSure = 8;  // as near to a centre line, no other one can be nearer
  const auto lateral = [&](const ViewPiece& v, float& l) {
    if ((p - v.start).dot(v.start_along) < 0 || (p - v.end).dot(v.end_along) >= 0) return false;
    if (v.curvature == 0) {
      l = (p.x() - v.start.x()) * v.start_along.y() - (p.y() - v.start.y()) * v.start_along.x();
    } else {
      const float distance = (p - v.centre).norm();
      l = v.curvature > 0 ? 1 / v.curvature - distance : distance + 1 / v.curvature;
    }
    return true;
  };
  Located best{-1, 1e9F};
  float l = 0;
  if (hint >= 0 && lateral(pieces[static_cast<std::size_t>(hint)], l) && std::abs(l) < kSure) return {hint, l};
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (lateral(pieces[i], l) && std::abs(l) < std::abs(best.l)) best = {static_cast<int>(i), l};
  return best;
}

Lane Scene::lane(const Located& at, const Eigen::Vector2f& p) const {
  const ViewPiece& piece = pieces[static_cast<std::size_t>(at.piece)];
  Lane lane;
  lane.along = piece.start_along;
  lane.s = (p - piece.start).dot(lane.along);
  if (piece.curvature != 0) {
    const float sign = piece.curvature > 0 ? 1.0F : -1.0F;
    const Eigen::Vector2f q = p - piece.centre, right(lane.along.y(), -lane.along.x());
    const float turn = std::atan2(q.dot(lane.along), -sign * q.dot(right));
    lane.s = turn / std::abs(piece.curvature);
    lane.along = std::cos(turn) * lane.along + sign * std::sin(turn) * right;
    lane.stretch = 1 / std::max(1 - piece.curvature * at.l, 0.1F);
  }
  lane.right = {lane.along.y(), -lane.along.x()};
  return lane;
}

double Scene::s_of(const Located& at, const Eigen::Vector2f& p) const {
  if (at.piece < 0) return pieces.empty() ? 0 : pieces.back().s + static_cast<double>(pieces.back().length);
  return pieces[static_cast<std::size_t>(at.piece)].s + static_cast<double>(lane(at, p).s);
}

Above Scene::above_road(const Eigen::Vector3f& ray, float t, int& hint) const {
  const Eigen::Vector2f p(t * ray.x(), t * ray.z());
  Above above;
  above.at = locate(p, hint);
  hint = above.at.piece;
  above.height = static_cast<float>(-eye.y() - path->height(s_of(above.at, p))) - t * ray.y();
  return above;
}

// In front of the houses no metre rises faster: on the inside of the turns the street is so much shorter than its
// centre line.
float Scene::descent(const Eigen::Vector3f& ray) const {
  constexpr float kInside = 2.4F;
  return ray.y() + kInside * static_cast<float>(path->steepest()) * Eigen::Vector2f(ray.x(), ray.z()).norm();
}

float Scene::depth_of_ground(const Eigen::Vector3f& ray, float up, float from, int& hint) const {
  constexpr float kNear = 1e-4F;
  constexpr int kMostSteps = 100;
  if (path->is_level()) return ray.y() < 1e-5F ? kNever : (static_cast<float>(-eye.y()) - up) / ray.y();
  const float fastest = descent(ray);
  if (fastest < 1e-5F) return kNever;
  float t = from;
  for (int i = 0; i < kMostSteps && t < kFarthest; ++i) {
    const float left = above_road(ray, t, hint).height - up;
    if (std::abs(left) < kNear) return t;
    t += left / fastest;
  }
  return kNever;
}

Eigen::Vector3f Scene::ground_normal(const Located& at, const Eigen::Vector2f& p) const {
  if (path->is_level() || at.piece < 0) return {0, 1, 0};
  const Lane here = lane(at, p);
  const Eigen::Vector2f rise = static_cast<float>(path->slope(s_of(at, p))) * here.stretch * here.along;
  return {rise.x(), 1, rise.y()};
}

World::World(const SyntheticOptions& options, const Camera& camera)
    : drive(options, fold(options.seed)),
      street(drive.path(), fold(options.seed), static_cast<float>(7.0 / camera.fx), options.threads),
      walkers(options, drive, fold(options.seed)),
      wardrobe(make_wardrobe(fold(options.seed))) {
  Random random(hash(fold(options.seed), 6));
  const float azimuth = random.uniform(0, 6.2831853F);
  sun = Eigen::Vector3f(std::cos(azimuth), -0.75F, std::sin(azimuth)).normalized();
}

float light_on(const Eigen::Vector3f& normal, const Eigen::Vector3f& sun) {
  return 0.7F - 0.16F * normal.y() + 0.46F * std::max(normal.dot(sun), 0.0F);
}

void compose(const World& world, const RayTable& rays, int frame, Scene& scene) {
  const SE3 T = world.drive.T_street_camera(frame);
  scene.path = &world.drive.path();
  scene.eye = T.t;
  scene.R = T.R.cast<float>();
  scene.parts.clear();
  scene.pieces.clear();
  scene.shades.clear();
  scene.people.clear();
  scene.bodies.clear();
  add_pieces(world.drive.path(), world.drive.s(frame), scene.eye, scene.pieces);
  std::vector<const Part*> things;
  std::vector<const GroundShade*> shades;
  world.street.collect(world.drive.s(frame) - kBehind, world.drive.s(frame) + kAhead, things, shades);
  for (const GroundShade* shade : shades) scene.shades.push_back(*shade);
  add_people(world, frame, scene);
  for (const Part& part : scene.bodies) things.push_back(&part);
  for (const Part* part : things) {
    ViewPart view = place(*part, scene.eye, scene.R);
    if (frame_part(rays, scene, view)) scene.parts.push_back(view);
  }
  std::stable_sort(scene.parts.begin(), scene.parts.end(),
                   [](const ViewPart& a, const ViewPart& b) { return a.nearest < b.nearest; });
  if (scene.parts.size() > 65535) scene.parts.resize(65535);
  scene.light.assign(scene.parts.size(), 1);
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    const ViewPart& view = scene.parts[i];
    if (view.part->shape != Shape::quad) continue;
    const Eigen::Vector3f normal = view.part->to_local.row(2).transpose() * (view.o.z() > 0 ? 1.0F : -1.0F);
    scene.light[i] = light_on(normal, world.sun);
  }
  sort_into_tiles(rays.camera(), scene);
  sort_shades(rays, scene);
}

}  // namespace pavo::synthetic
