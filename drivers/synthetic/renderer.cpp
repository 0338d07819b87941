#include "drivers/synthetic/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/synthetic/layout.h"
#include "drivers/synthetic/parallel.h"
#include "drivers/synthetic/random.h"
#include "drivers/synthetic/ray.h"

namespace pavo::synthetic {
namespace {

constexpr std::uint32_t kForced = 0x80000000U;  ///< set in an id: the pixel needs all its samples
constexpr int kSamples = 8;
/// The places of eight rooks that do not threaten each other; the first four, to the left, right, below and above, tell
/// whether an edge runs through the pixel at all.
constexpr std::array<std::array<float, 2>, kSamples> kOffsets{{{-0.4375F, -0.0625F},
                                                               {0.4375F, 0.0625F},
                                                               {-0.0625F, 0.4375F},
                                                               {0.0625F, -0.4375F},
                                                               {-0.3125F, -0.3125F},
                                                               {0.3125F, 0.3125F},
                                                               {-0.1875F, 0.1875F},
                                                               {0.1875F, -0.1875F}}};

std::uint32_t beside_road(float l) {
  constexpr auto kStreet = static_cast<float>(kKerb + 5.45);
  return std::abs(l) > kStreet ? kField : kSidewalk;
}

/// About normally distributed, sigma 1: the sum of the four bytes of a hash.
float sensor_noise(std::uint32_t frame_hash, std::uint32_t pixel) {
  const std::uint32_t h = hash(frame_hash + pixel * 0x9e3779b9U);
  const auto sum = static_cast<float>((h & 255) + (h >> 8 & 255) + (h >> 16 & 255) + (h >> 24));
  return (sum - 510.0F) * (1 / 147.8F);
}

}  // namespace

Renderer::Renderer(const SyntheticOptions& options, const Camera& camera)
    : options_(options),
      rays_(camera),
      world_(options, camera),
      hits_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)) {}

/// Bands of rows are the grains of work: nothing passes from one row to another, so that their order cannot matter.
template <typename F>
void Renderer::for_rows(const F& f) const {
  constexpr int kBand = 8;
  const int height = rays_.camera().height;
  for_each_index((height + kBand - 1) / kBand, options_.threads, [&](int band) {
    for (int y = band * kBand; y < std::min((band + 1) * kBand, height); ++y) f(y);
  });
}

void Renderer::render(int frame, std::uint8_t* pixels) {
  compose(world_, rays_, frame, scene_);
  for_rows([&](int y) { trace_row(y); });
  for_rows([&](int y) { shade_row(frame, y, pixels + static_cast<std::ptrdiff_t>(y) * rays_.camera().width); });
}

// Where a ray goes through the kerb's face, between a point over the road and one over the sidewalk, below its edge:
// two steps of the secant.
float Renderer::trace_kerb(const Scene& scene, const Eigen::Vector2f& flat, float a, float la, float b, float lb,
                           int hint) const {
  constexpr auto kEdge = static_cast<float>(kKerb);
  float t = a;
  for (int i = 0; i < 2; ++i) {
    t = a + (b - a) * (kEdge - la) / (lb - la);
    const float l = std::abs(scene.locate(t * flat, hint).l);
    if (std::abs(l - kEdge) < 1e-5F) break;
    (l < kEdge ? a : b) = t;
    (l < kEdge ? la : lb) = l;
  }
  return t;
}

Renderer::Hit Renderer::trace_ground(const Scene& scene, const Eigen::Vector3f& d, int& hint) const {
  constexpr auto kEdge = static_cast<float>(kKerb), kHigh = static_cast<float>(kKerbHeight);
  if (!scene.path->is_level()) return trace_hills(scene, d, hint);
  const float high = scene.depth_of_ground(d, kHigh, 0, hint);
  if (high > kFarthest) return {kFarthest, kSky};
  const Eigen::Vector2f flat(d.x(), d.z());
  const Located up = scene.locate(high * flat, hint);
  hint = up.piece;
  if (std::abs(up.l) > kEdge) return {high, beside_road(up.l)};
  const float low = scene.depth_of_ground(d, 0, 0, hint);
  const Located down = scene.locate(low * flat, hint);
  if (std::abs(down.l) <= kEdge) return {low, kRoad};
  return {trace_kerb(scene, flat, high, std::abs(up.l), low, std::abs(down.l), hint), kKerbFace};
}

// By steps that are too short to pass through anything, but for two pixels' height: a ray that grazes a crest would
// take thousands. Over a crest it may come lower than the kerb's edge and not meet the road.
Renderer::Hit Renderer::trace_hills(const Scene& scene, const Eigen::Vector3f& d, int& hint) const {
  constexpr auto kEdge = static_cast<float>(kKerb), kHigh = static_cast<float>(kKerbHeight);
  constexpr float kNear = 1e-4F;
  constexpr int kMostSteps = 1000;  // never reached
  const float fastest = scene.descent(d);
  if (fastest < 1e-5F) return {kFarthest, kSky};
  const Eigen::Vector2f flat(d.x(), d.z());
  float t = 0, t_between = -1, l_between = 0;  // where it was between the kerbs last
  for (int i = 0; i < kMostSteps && t < kFarthest; ++i) {
    const Above here = scene.above_road(d, t, hint);
    const float l = std::abs(here.at.l), over_edge = here.height - kHigh;
    const bool over_road = l <= kEdge;
    if (over_road ? here.height < kNear : over_edge < kNear) {
      if (over_road) return {t, kRoad};
      if (t_between < 0) return {t, beside_road(l)};
      return {trace_kerb(scene, flat, t_between, l_between, t, l, hint), kKerbFace};
    }
    const bool between = over_road && over_edge < 0;
    t_between = between ? t : -1, l_between = l;
    const float least = std::max(0.01F, 0.003F * t);  // of height, that a step is worth
    t += std::max(between ? here.height : over_edge, least) / fastest;
  }
  return {kFarthest, kSky};
}

Renderer::Hit Renderer::trace(const Scene& scene, float x, float y, float pixel,
                              const std::vector<std::uint16_t>& parts, int& hint) const {
  const Eigen::Vector3f direction = scene.R.col(0) * x + scene.R.col(1) * y + scene.R.col(2);
  Hit best = trace_ground(scene, direction, hint);
  for (const std::uint16_t i : parts) {
    const ViewPart& view = scene.parts[i];
    if (view.nearest >= best.t) break;
    int face = 0;
    const float t = intersect(view, x, y, pixel, face);
    if (t < best.t) best = {t, part_id(i, face)};
  }
  return best;
}

void Renderer::trace_row(int y) {
  const int width = rays_.camera().width;
  Hit* row = hits_.data() + static_cast<std::ptrdiff_t>(y) * width;
  int hint = -1;
  std::vector<std::uint16_t> here;
  for (int x = 0; x < width; ++x) {
    const Eigen::Vector2f ray = rays_.at(x, y);
    if (!(std::abs(ray.x()) < kFarthest)) {
      row[x] = {0, kNothing};
      continue;
    }
    const float pixel = std::abs(rays_.at(x + 1, y).x() - ray.x());
    const bool thin = scene_.parts_at(x, y, here);
    row[x] = trace(scene_, ray.x(), ray.y(), pixel, here, hint);
    if (thin) row[x].id |= kForced;
  }
}

/// Whether another surface comes near to the pixel.
bool Renderer::is_edge(int x, int y) const {
  const int width = rays_.camera().width, height = rays_.camera().height;
  const Hit* hit = hits_.data() + static_cast<std::ptrdiff_t>(y) * width + x;
  const std::uint32_t id = hit->id & ~kForced;
  if (id == kNothing) return false;
  if (hit->id & kForced) return true;
  for (int j = y > 0 ? -1 : 0; j <= (y + 1 < height ? 1 : 0); ++j)
    for (int i = x > 0 ? -1 : 0; i <= (x + 1 < width ? 1 : 0); ++i)
      if ((hit[static_cast<std::ptrdiff_t>(j) * width + i].id & ~kForced) != id) return true;
  return false;
}

void Renderer::shade_row(int frame, int y, std::uint8_t* row) const {
  const int width = rays_.camera().width;
  const auto frame_hash = hash(static_cast<std::uint32_t>(options_.seed), static_cast<std::uint32_t>(frame), 77);
  const auto sigma = static_cast<float>(options_.noise_sigma);
  int hint = -1;
  std::vector<std::uint16_t> here;
  for (int x = 0; x < width; ++x) {
    const Hit hit = hits_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    float value = 0;
    if (is_edge(x, y))
      value = shade_edge(x, y, hit, hint, here);
    else if (hit.id != kNothing)
      value = shade(Ray(scene_, rays_, x, y), {hit.t, hit.id & ~kForced}, scene_.tile(x, y), hint);
    value *= 255;
    if (sigma > 0) value += sigma * sensor_noise(frame_hash, static_cast<std::uint32_t>(y * width + x));
    row[x] = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
  }
}

/// The surfaces that a pixel's samples met.
class Renderer::Samples {
 public:
  struct Group {
    Hit hit;
    float count = 0;
    float dx = 0, dy = 0;              ///< sum of its samples' places
    float first_dx = 0, first_dy = 0;  ///< where `hit` is
  };

  void add(const Hit& hit, float dx, float dy) {
    std::size_t g = 0;
    while (g < used_ && groups_[g].hit.id != hit.id) ++g;
    if (g == used_) groups_[used_++] = {hit, 0, 0, 0, dx, dy};
    groups_[g].count += 1;
    groups_[g].dx += dx;
    groups_[g].dy += dy;
  }
  bool all_met(std::uint32_t id) const { return used_ == 1 && groups_[0].hit.id == id; }
  const Group* begin() const { return groups_.data(); }
  const Group* end() const { return groups_.data() + used_; }

 private:
  std::array<Group, kSamples> groups_;
  std::size_t used_ = 0;
};

/// Up to eight samples; each surface among them is shaded once, in the middle of its samples.
float Renderer::shade_edge(int x, int y, Hit centre, int& hint, std::vector<std::uint16_t>& here) const {
  const Ray middle(scene_, rays_, x, y);
  const std::size_t tile = scene_.tile(x, y);
  const float pixel = middle.pixel();
  const bool forced = (centre.id & kForced) != 0;
  centre.id &= ~kForced;
  const bool leaf = centre.id >= kFirstPart && scene_.parts[part_of(centre.id)].part->shape == Shape::foliage;
  scene_.parts_at(x, y, here);
  Samples samples;
  float count = 0;
  for (const auto& [dx, dy] : kOffsets) {
    const Eigen::Vector2f at = middle.at(dx, dy);
    samples.add(trace(scene_, at.x(), at.y(), pixel, here, hint), dx, dy);
    count += 1;
    if (count == 4 && !forced && samples.all_met(centre.id)) return shade(middle, centre, tile, hint);
    if (count == 4 && leaf) break;  // where all is edges, four will do
  }
  float sum = 0;
  for (const Samples::Group& group : samples) {
    // a flat surface goes on beyond its edge, a round one may not be met in the middle
    const bool flat = group.hit.id < kFirstPart || scene_.parts[part_of(group.hit.id)].part->shape == Shape::quad;
    const Ray ray = flat ? middle.moved(group.dx / group.count, group.dy / group.count)
                         : middle.moved(group.first_dx, group.first_dy);
    sum += group.count * shade(ray, group.hit, tile, hint);
  }
  return sum / count;
}

}  // namespace pavo::synthetic
