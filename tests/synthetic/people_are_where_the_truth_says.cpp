#include <algorithm>
#include <cmath>
#include <map>

#include "tests/synthetic/support.h"

namespace pavo {
namespace {

using test::Gray;
using test::render;
using test::small_street;

constexpr int kVisibleChange = 14;  ///< gray levels: what the soft shade at the feet never reaches far from them

SyntheticOptions crowd(int frames) {
  SyntheticOptions options = small_street(frames);
  options.width = 480;
  options.height = 145;
  options.density = 3;
  options.companions = 4;
  return options;
}

bool inside(const SyntheticPerson& p, int x, int y) {
  const double margin = 1.5 + 0.08 * p.height;  // their feet shade the ground beside them
  return x >= p.x - margin && x <= p.x + p.width + margin && y >= p.y - 1.5 && y <= p.y + p.height + margin;
}

TEST(SyntheticPeople, ChangeNothingOutsideOfTheirBoxes) {
  SyntheticOptions options = crowd(6);
  SyntheticStreet street(options);
  const auto with = test::read_all(street);
  options.people = false;
  options.companions = 0;
  const auto without = render(options);
  int changed = 0;
  for (int k = 0; k < 6; ++k) {
    const Gray &a = with[static_cast<std::size_t>(k)], &b = without[static_cast<std::size_t>(k)];
    const auto people = street.people(k);
    for (int y = 0; y < a.height; ++y) {
      for (int x = 3; x < a.width - 3; ++x) {  // somebody just outside shades the ground inside
        if (std::abs(a.at(x, y) - b.at(x, y)) <= kVisibleChange) continue;
        ++changed;
        EXPECT_TRUE(std::any_of(people.begin(), people.end(), [&](const auto& p) { return inside(p, x, y); }))
            << "frame " << k << ": " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(changed, 3000);
}

TEST(SyntheticPeople, FillTheirVisibleBoxes) {
  SyntheticOptions options = crowd(6);
  SyntheticStreet street(options);
  const auto with = test::read_all(street);
  options.people = false;
  options.companions = 0;
  const auto without = render(options);
  int seen = 0;
  for (int k = 0; k < 6; ++k) {
    for (const SyntheticPerson& p : street.people(k)) {
      if (p.visible_width < 8 || p.visible_fraction < 0.8F) continue;
      int changed = 0, all = 0;
      for (int y = static_cast<int>(std::ceil(p.visible_y)); static_cast<float>(y) < p.visible_y + p.visible_height;
           ++y)
        for (int x = static_cast<int>(std::ceil(p.visible_x)); static_cast<float>(x) < p.visible_x + p.visible_width;
             ++x, ++all)
          changed += with[static_cast<std::size_t>(k)].at(x, y) != without[static_cast<std::size_t>(k)].at(x, y);
      EXPECT_GT(changed, all / 4) << "frame " << k << ", person " << p.id;
      ++seen;
    }
  }
  EXPECT_GT(seen, 6);
}

TEST(SyntheticPeople, HaveSoundBoxes) {
  SyntheticStreet street(crowd(20));
  const Camera& camera = *street.info().camera;
  std::map<int, int> frames_of;
  for (int k = 0; k < 20; ++k) {
    float depth = 0;
    for (const SyntheticPerson& p : street.people(k)) {
      ++frames_of[p.id];
      EXPECT_GE(p.depth_m, depth);  // the nearest first
      depth = p.depth_m;
      EXPECT_GT(p.visible_fraction, 0);
      EXPECT_LE(p.visible_fraction, 1);
      EXPECT_GE(p.visible_x, std::max(p.x - 1, -0.5F));
      EXPECT_GE(p.visible_y, std::max(p.y - 1, -0.5F));
      EXPECT_LE(p.visible_x + p.visible_width, std::min(p.x + p.width + 1, static_cast<float>(camera.width) - 0.5F));
      EXPECT_LE(p.visible_y + p.visible_height, std::min(p.y + p.height + 1, static_cast<float>(camera.height) - 0.5F));
      // between 1.5 and 2 m tall, in the picture: f * height / depth
      const double tall = p.height * p.depth_m / camera.fy;
      EXPECT_TRUE(p.depth_m < 6 || (tall > 1.4 && tall < 2.1)) << tall;
      EXPECT_LT(p.width, 0.85F * p.height);
    }
  }
  EXPECT_GE(frames_of.size(), 6U);
  EXPECT_TRUE(std::any_of(frames_of.begin(), frames_of.end(), [](const auto& f) { return f.second >= 15; }));
}

TEST(SyntheticPeople, CompanionsKeepTheirPlaceInThePicture) {
  SyntheticOptions options = small_street(25);
  options.people = false;
  options.companions = 5;
  SyntheticStreet street(options);
  std::map<int, std::vector<float>> depths, columns;
  for (int k = 0; k < 25; ++k) {
    for (const SyntheticPerson& p : street.people(k)) {
      EXPECT_TRUE(p.companion);
      depths[p.id].push_back(p.depth_m);
      columns[p.id].push_back(p.x + p.width / 2);
    }
  }
  EXPECT_GE(depths.size(), 3U);
  for (const auto& [id, d] : depths) {
    const auto [low, high] = std::minmax_element(d.begin(), d.end());
    EXPECT_LT(*high - *low, 0.6F) << id;
    const auto [left, right] = std::minmax_element(columns[id].begin(), columns[id].end());
    EXPECT_LT(*right - *left, 45) << id;
  }
}

TEST(SyntheticPeople, MoveAtWalkingPace) {
  SyntheticOptions options = small_street(40);
  options.speed_mps = 0;  // a camera that stands, so that depth changes by their own motion
  options.density = 3;
  SyntheticStreet street(options);
  EXPECT_EQ(street.info().groundtruth->T_w_c.back().t, street.info().groundtruth->T_w_c.front().t);
  const Camera& camera = *street.info().camera;
  std::map<int, Eigen::Vector2d> last;
  int moved = 0;
  for (int k = 0; k < 40; k += 10) {
    for (const SyntheticPerson& p : street.people(k)) {
      const Eigen::Vector2d at((p.x + p.width / 2 - camera.cx) / camera.fx * p.depth_m, p.depth_m);
      if (last.contains(p.id)) {
        const double metres_per_second = (at - last[p.id]).norm();  // ten frames are a second
        EXPECT_LT(metres_per_second, 2.6);
        moved += metres_per_second > 0.4;
      }
      last[p.id] = at;
    }
  }
  EXPECT_GE(moved, 3);
}

TEST(SyntheticPeople, AreAskedForWithinTheDrive) {
  const SyntheticStreet street(small_street(3));
  EXPECT_THROW((void)street.people(-1), std::out_of_range);
  EXPECT_THROW((void)street.people(3), std::out_of_range);
  EXPECT_NO_THROW((void)street.people(2));
}

}  // namespace
}  // namespace pavo
