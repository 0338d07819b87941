// A run of days remembers no more of its path than its picture needs.
#include <gtest/gtest.h>

#include "tools/pavo/kept_trajectory.h"

namespace pavo {
namespace {

SE3 at(double x) {
  SE3 T;
  T.t.x() = x;
  return T;
}

TEST(KeptTrajectory, StaysSmallAndEvenWithItsEnds) {
  for (const int count : {0, 1, 2, 8191, 8192, 8193, 1'000'000}) {
    KeptTrajectory kept(false);
    for (int i = 0; i < count; ++i) {
      kept.add(i, at(i));
      ASSERT_EQ(kept.last().t.x(), i);
      ASSERT_LE(kept.trajectory().T_w_c.size(), KeptTrajectory::kMost);
    }
    kept.finish();
    const Trajectory& t = kept.trajectory();
    ASSERT_EQ(t.T_w_c.size(), t.t_ns.size());
    EXPECT_EQ(kept.empty(), count == 0);
    if (count == 0) continue;
    EXPECT_GE(t.T_w_c.size(), std::min<std::size_t>(static_cast<std::size_t>(count), KeptTrajectory::kMost / 2));
    EXPECT_EQ(t.t_ns.front(), 0);
    EXPECT_EQ(t.t_ns.back(), count - 1);
    for (std::size_t i = 0; i < t.t_ns.size(); ++i) ASSERT_EQ(t.T_w_c[i].t.x(), static_cast<double>(t.t_ns[i]));
    for (std::size_t i = 2; i + 1 < t.t_ns.size(); ++i)
      ASSERT_EQ(t.t_ns[i] - t.t_ns[i - 1], t.t_ns[1] - t.t_ns[0]) << "evenly";
  }
}

TEST(KeptTrajectory, KeepsAllWhereItIsCompared) {
  KeptTrajectory kept(true);
  for (int i = 0; i < 20000; ++i) kept.add(i, at(i));
  kept.finish();
  EXPECT_EQ(kept.trajectory().T_w_c.size(), 20000u);
}

}  // namespace
}  // namespace pavo
