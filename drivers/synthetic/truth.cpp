// Who is in the picture, where, and how much of him can be seen.
#include <algorithm>
#include <cmath>

#include "drivers/synthetic/ray.h"
#include "drivers/synthetic/renderer.h"

namespace pavo::synthetic {

std::vector<SyntheticPerson> Renderer::people(int frame) const {
  Scene scene;
  compose(world_, rays_, frame, scene);
  std::vector<SyntheticPerson> found;
  for (std::size_t i = 0; i < scene.people.size(); ++i) {
    const SyntheticPerson person = measure(scene, i);
    if (person.visible_fraction > 0) found.push_back(person);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const SyntheticPerson& a, const SyntheticPerson& b) { return a.depth_m < b.depth_m; });
  return found;
}

SyntheticPerson Renderer::measure(const Scene& scene, std::size_t who) const {
  const VisiblePerson& seen = scene.people[who];
  SyntheticPerson person;
  person.id = seen.id;
  person.companion = seen.companion;
  const Camera& camera = rays_.camera();
  float x0 = 1e9F, y0 = 1e9F, x1 = -1e9F, y1 = -1e9F, depth = 0;
  std::vector<ViewPart> body;
  for (std::size_t i = seen.first; i < seen.last; ++i) {
    body.push_back(place(scene.bodies[i], scene.eye, scene.R));
    const Bounds bounds = project(body.back(), scene.eye, scene.R);
    if (bounds.unbounded) return person;
    float a, b, c, d;
    rays_.to_pixels(bounds, a, b, c, d);
    x0 = std::min(x0, a);
    y0 = std::min(y0, b);
    x1 = std::max(x1, c);
    y1 = std::max(y1, d);
    depth += (bounds.nearest + bounds.farthest) / 2 / static_cast<float>(seen.last - seen.first);
  }
  person.x = x0;
  person.y = y0;
  person.width = x1 - x0;
  person.height = y1 - y0;
  person.depth_m = depth;
  if (x1 < 0 || y1 < 0 || x0 > static_cast<float>(camera.width - 1) || y0 > static_cast<float>(camera.height - 1))
    return person;

  int whole = 0, visible = 0, left = camera.width, top = camera.height, right = -1, bottom = -1, hint = -1;
  for (int y = static_cast<int>(std::floor(y0)); y <= static_cast<int>(std::ceil(y1)); ++y) {
    for (int x = static_cast<int>(std::floor(x0)); x <= static_cast<int>(std::ceil(x1)); ++x) {
      const bool inside = x >= 0 && y >= 0 && x < camera.width && y < camera.height;
      const Eigen::Vector2f ray = inside ? rays_.at(x, y) : rays_.look(x, y);
      if (!(std::abs(ray.x()) < kFarthest)) continue;
      int face = 0;
      const auto met = [&](const ViewPart& part) { return intersect(part, ray.x(), ray.y(), 0, face) < kFarthest; };
      if (std::none_of(body.begin(), body.end(), met)) continue;
      ++whole;
      if (!inside) continue;
      const Hit hit = trace(scene, ray.x(), ray.y(), std::abs(rays_.at(x + 1, y).x() - ray.x()),
                            scene.tile_parts[scene.tile(x, y)], hint);
      if (hit.id < kFirstPart || scene.parts[part_of(hit.id)].part->person != static_cast<int>(who)) continue;
      ++visible;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  if (visible == 0) return person;
  person.visible_x = static_cast<float>(left) - 0.5F;
  person.visible_y = static_cast<float>(top) - 0.5F;
  person.visible_width = static_cast<float>(right - left + 1);
  person.visible_height = static_cast<float>(bottom - top + 1);
  person.visible_fraction = static_cast<float>(visible) / static_cast<float>(whole);
  return person;
}

}  // namespace pavo::synthetic
