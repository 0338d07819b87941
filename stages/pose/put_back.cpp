#include "stages/pose/put_back.h"

#include <Eigen/LU>
#include <algorithm>

#include "stages/pose/essential.h"
#include "stages/pose/sampson.h"

namespace pavo {
namespace {

enum class Says { nothing, street, person };

struct Judge {
  Judge(const Camera& of, const SE3& T, const PutBackOptions& how) : camera(of), T_c_p(T), options(how) {
    const Eigen::Matrix3d K_inverse = intrinsic_matrix(camera).inverse();
    F = K_inverse.transpose() * essential_of(T_c_p) * K_inverse;
  }

  Says operator()(const PointPair& pair) const {
    if (!(sampson_distance(F, pair) <= options.threshold_px)) return Says::person;
    if (parallax_px(T_c_p, pair, camera) < options.least_parallax_px) return Says::nothing;
    const Depths depths =
        triangulate_depths(T_c_p, ray(pair.x_previous, pair.y_previous), ray(pair.x_current, pair.y_current));
    return depths.previous > 0 && depths.current > 0 ? Says::street : Says::person;
  }

  Eigen::Vector3d ray(float x, float y) const {
    return {(static_cast<double>(x) - camera.cx) / camera.fx, (static_cast<double>(y) - camera.cy) / camera.fy, 1};
  }

  const Camera& camera;
  const SE3& T_c_p;
  const PutBackOptions& options;
  Eigen::Matrix3d F;
};

bool moves_with_street(std::span<const PointPair> on_people, const PersonBox& person, const PeopleMaskOptions& mask,
                       const Judge& judge) {
  int with = 0, against = 0;
  for (const PointPair& pair : on_people) {
    if (!in_outline(person, pair.x_current, pair.y_current, mask)) continue;
    const Says says = judge(pair);
    with += says == Says::street;
    against += says == Says::person;
  }
  return with >= judge.options.least_matches && with >= judge.options.least_share * (with + against);
}

}  // namespace

void put_back(std::span<const PointPair> on_people, const People& people, const PeopleMaskOptions& mask,
              const Camera& camera, const SE3& T_c_p, const PutBackOptions& options, PointPairs& street) {
  const Judge judge(camera, T_c_p, options);
  const std::size_t before = street.size();
  for (const PointPair& pair : on_people)
    if (judge(pair) == Says::street) street.push_back(pair);
  for (const PersonBox& person : people) {
    if (moves_with_street(on_people, person, mask, judge)) continue;
    const auto begin = street.begin() + static_cast<std::ptrdiff_t>(before);
    street.erase(std::remove_if(begin, street.end(),
                                [&](const PointPair& p) { return in_outline(person, p.x_current, p.y_current, mask); }),
                 street.end());
  }
}

}  // namespace pavo
