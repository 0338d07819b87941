// The refined path, given out frame by frame as it becomes final, is the one that is computed from all at the end; and
// what is kept stays small.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "tools/pavo/refined_path.h"

namespace pavo::test {
namespace {

SE3 random_pose(std::mt19937& random, double size) {
  const auto number = [&] { return size * (static_cast<double>(random()) / 2147483648.0 - 1); };
  const double x = number(), y = number(), z = number();
  SE3 T;
  T.R = (Eigen::AngleAxisd(number(), Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(number(), Eigen::Vector3d::UnitY()))
            .toRotationMatrix();
  T.t = {x, y, z};
  return T;
}

/// All at once: every published pose and every link is kept to the end.
class KeptPath {
 public:
  void add(const SE3& T_w_c, bool is_keyframe) {
    if (is_keyframe) {
      const SE3 before = keyframes.empty() ? SE3{} : published[keyframes.back()];
      keyframes.push_back(published.size());
      links.push_back(before.inverse() * T_w_c);
    }
    published.push_back(T_w_c);
  }
  void adjust(const std::vector<KeyframePose>& window) {
    for (std::size_t i = 1; i < window.size(); ++i)
      for (std::size_t k = 1; k < keyframes.size(); ++k)
        if (static_cast<std::int64_t>(keyframes[k]) == window[i].frame &&
            static_cast<std::int64_t>(keyframes[k - 1]) == window[i - 1].frame)
          links[k] = window[i - 1].T_w_c.inverse() * window[i].T_w_c;
  }
  std::vector<SE3> refined() const {
    std::vector<SE3> path;
    SE3 at, was;
    for (std::size_t i = 0, k = 0; i < published.size(); ++i) {
      if (k < keyframes.size() && keyframes[k] == i) {
        at = at * links[k++];
        was = published[i];
      }
      path.push_back(at * (was.inverse() * published[i]));
    }
    return path;
  }

  std::vector<SE3> published, links;
  std::vector<std::size_t> keyframes;
};

void take_final(RefinedPath& path, std::vector<SE3>& given) {
  while (const std::optional<SE3> T = path.next_final()) given.push_back(*T);
}

TEST(RefinedPath, IsGivenOutAsItWouldBeAtTheEnd) {
  std::mt19937 random(3);
  RefinedPath path;
  KeptPath kept;
  std::vector<SE3> given;
  std::vector<KeyframePose> window;
  SE3 at;
  std::size_t waiting = 0;
  for (std::int64_t frame = 0; frame < 2000; ++frame) {
    at = at * random_pose(random, 0.1);
    const bool is_keyframe = frame > 3 && random() % 5 == 0;  // a start without any
    path.add(at, is_keyframe);
    kept.add(at, is_keyframe);
    if (is_keyframe) {
      if (random() % 40 == 0) window.clear();  // lost: a new map
      window.push_back({frame, at});
      if (window.size() > 7) window.erase(window.begin());
    }
    if (random() % 3 == 0) {
      for (KeyframePose& k : window) k.T_w_c = k.T_w_c * random_pose(random, 0.02);
      path.adjust(window);
      kept.adjust(window);
    }
    take_final(path, given);
    waiting = std::max(waiting, kept.published.size() - given.size());
  }
  path.end();
  take_final(path, given);
  const std::vector<SE3> expected = kept.refined();
  ASSERT_EQ(given.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(given[i].t, expected[i].t) << i;
    EXPECT_EQ(given[i].R, expected[i].R) << i;
  }
  EXPECT_LT(waiting, 200u);
}

TEST(RefinedPath, OfACameraThatStandsForHoursIsNotKept) {
  RefinedPath path;
  path.add({}, true);
  std::size_t given = 0;
  constexpr std::size_t kFrames = RefinedPath::kMostKept + 1000;
  for (std::size_t n = 1; n < kFrames; ++n) {
    path.add({}, false);
    while (path.next_final()) ++given;
  }
  EXPECT_EQ(given, 1000u);
}

}  // namespace
}  // namespace pavo::test
