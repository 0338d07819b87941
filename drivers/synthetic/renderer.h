// Pictures of the street.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/synthetic/options.h"
#include "drivers/synthetic/scene.h"

namespace pavo::synthetic {

/// Casts a ray through every pixel, shades what it meets once with the texture filtered over the pixel's footprint,
/// and where surfaces meet inside a pixel casts eight (multisampling: edges are smoothed, textures are not sampled
/// more than needed). One frame at a time; render() keeps its memory.
class Renderer {
 public:
  Renderer(const SyntheticOptions& options, const Camera& camera);

  const World& world() const { return world_; }
  /// Renders into width x height bytes. Blocks; uses options.threads threads. The same bytes for any number of them.
  void render(int frame, std::uint8_t* pixels);
  /// The truth about who is in the picture, nearest first.
  std::vector<SyntheticPerson> people(int frame) const;

 private:
  struct Hit {
    float t = 0;
    std::uint32_t id = 0;
  };
  struct Ray;
  class Samples;

  Hit trace(const Scene& scene, float x, float y, float pixel, const std::vector<std::uint16_t>& parts,
            int& hint) const;
  Hit trace_ground(const Scene& scene, const Eigen::Vector3f& direction, int& hint) const;
  Hit trace_hills(const Scene& scene, const Eigen::Vector3f& direction, int& hint) const;
  float trace_kerb(const Scene& scene, const Eigen::Vector2f& flat, float a, float la, float b, float lb,
                   int hint) const;
  float shade(const Ray& ray, Hit hit, std::size_t tile, int& hint) const;
  float shade_ground(const Ray& ray, Hit hit, std::size_t tile, int& hint) const;
  float shade_sky(const Ray& ray) const;
  float shade_part(const Ray& ray, Hit hit) const;
  void trace_row(int y);
  void shade_row(int frame, int y, std::uint8_t* row) const;
  float shade_edge(int x, int y, Hit centre, int& hint, std::vector<std::uint16_t>& here) const;
  bool is_edge(int x, int y) const;
  SyntheticPerson measure(const Scene& scene, std::size_t person) const;
  template <typename F>
  void for_rows(const F& f) const;

  SyntheticOptions options_;
  RayTable rays_;
  World world_;
  Scene scene_;
  std::vector<Hit> hits_;
};

}  // namespace pavo::synthetic
