// KITTI's pose files: what is read, what is refused and where, and that writing keeps every digit it promises.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <random>

#include "drivers/trajectories/trajectory_files.h"
#include "tests/support/data.h"
#include "tests/support/temporary.h"

namespace pavo {
namespace {

using test::complaint;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kIdentity = "1 0 0 0 0 1 0 0 0 0 1 0\n";

std::string kitti_refusal(const std::string& text) {
  return complaint([&] { parse_kitti_poses(text, "poses.txt"); });
}

Trajectory random_path(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Trajectory path;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(uniform(random), uniform(random), uniform(random), uniform(random) + 1.5).normalized();
    path.T_w_c.push_back(
        {q.toRotationMatrix(), 100 * Eigen::Vector3d(uniform(random), uniform(random), uniform(random))});
    path.t_ns.push_back(1'403'715'273'262'142'976 + static_cast<std::int64_t>(i) * 49'999'999);
  }
  return path;
}

TEST(KittiPoses, ReadTheMatrixRowByRow) {
  const Trajectory path = parse_kitti_poses("0 -1 0 10 1 0 0 20 0 0 1 30\n" + kIdentity, "poses.txt");
  ASSERT_EQ(path.T_w_c.size(), 2u);
  EXPECT_TRUE(path.t_ns.empty());
  EXPECT_EQ(path.T_w_c[0].t, Eigen::Vector3d(10, 20, 30));
  EXPECT_EQ(path.T_w_c[0].R * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
}

TEST(KittiPoses, TolerateWindowsEndsBlanksAndNoLastNewline) {
  EXPECT_EQ(
      parse_kitti_poses("1 0 0 0 0 1 0 0 0 0 1 0\r\n\t+1  0 0 1e0 0 1 0 0 0 0 1 -.5\r\n\r\n \n\n", "p").T_w_c.size(),
      2u);
  EXPECT_EQ(parse_kitti_poses("1 0 0 0 0 1 0 0 0 0 1 0", "p").T_w_c.size(), 1u);
}

TEST(KittiPoses, NameTheLineOfWhatIsWrong) {
  EXPECT_THAT(kitti_refusal(kIdentity + "1 0 0 0 0 1 0 0 0 0 1\n"), StartsWith("poses.txt:2: expected 12 numbers"));
  EXPECT_THAT(kitti_refusal(kIdentity + "1 0 0 0 0 1 0 0 0 0 1\n"), HasSubstr("found 11"));
  EXPECT_THAT(kitti_refusal(kIdentity + "1 0 0 0 0 1 0 0 0 0 1 0 7\n"), HasSubstr("found 13"));
  EXPECT_THAT(kitti_refusal(kIdentity + kIdentity + "1 0 0 nan 0 1 0 0 0 0 1 0\n"),
              StartsWith("poses.txt:3: expected a finite number"));
  EXPECT_THAT(kitti_refusal("1 0 0 -inf 0 1 0 0 0 0 1 0\n"),
              StartsWith("poses.txt:1: expected a finite number, found '-inf'"));
  EXPECT_THAT(kitti_refusal("1 0 0 1e999 0 1 0 0 0 0 1 0\n"), StartsWith("poses.txt:1: '1e999'"));
  EXPECT_THAT(kitti_refusal("1 0 0 1.0x 0 1 0 0 0 0 1 0\n"), HasSubstr("expected a number, found '1.0x'"));
  EXPECT_THAT(kitti_refusal("1 0 0 1,5 0 1 0 0 0 0 1 0\n"), HasSubstr("expected a number, found '1,5'"));
  EXPECT_THAT(kitti_refusal("1 0 0 +-1 0 1 0 0 0 0 1 0\n"), HasSubstr("expected a number"));
  EXPECT_THAT(kitti_refusal("1 0 0 2e9 0 1 0 0 0 0 1 0\n"), HasSubstr("1e9 m from the origin"));
  EXPECT_THAT(kitti_refusal(kIdentity + "\n" + kIdentity), StartsWith("poses.txt:2: a blank line"));
  EXPECT_THAT(kitti_refusal("# poses\n" + kIdentity), StartsWith("poses.txt:1: expected 12 numbers"));
  EXPECT_THAT(kitti_refusal(""), StartsWith("poses.txt: no pose in it"));
  EXPECT_THAT(kitti_refusal("\n\n"), StartsWith("poses.txt: no pose in it"));
}

TEST(KittiPoses, RefuseWhatIsNoRotation) {
  EXPECT_THAT(kitti_refusal("2 0 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("no rotation"));
  EXPECT_THAT(kitti_refusal("1 0 0 0 0 1 0 0 0 0 -1 0\n"), HasSubstr("no rotation")) << "a mirror";
  EXPECT_THAT(kitti_refusal("0 0 0 0 0 0 0 0 0 0 0 0\n"), HasSubstr("no rotation"));
  EXPECT_THAT(kitti_refusal("1 0 0 0 0 1.01 0 0 0 0 1 0\n"), HasSubstr("no rotation"));
}

TEST(KittiPoses, MendWhatWasRoundedAndLeaveTheRest) {
  const Trajectory mended = parse_kitti_poses("1.0002 0 0 0 0 1 1e-4 0 0 0 1 0\n", "p");
  EXPECT_TRUE((mended.T_w_c[0].R.transpose() * mended.T_w_c[0].R).isIdentity(1e-14));
  const Trajectory kept = parse_kitti_poses("1.0000001 0 0 0 0 1 0 0 0 0 1 0\n", "p");
  EXPECT_EQ(kept.T_w_c[0].R(0, 0), 1.0000001);
}

TEST(KittiPoses, GarbageInAMessageIsShortAndPrintable) {
  const std::string text = kitti_refusal("\x1b[31m\x07" + std::string(500, 'z') + " 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_LT(text.size(), 120u);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

TEST(KittiPoses, AreWrittenAsPrintfWould) {
  for (const SE3& pose : random_path(50, 1).T_w_c) {
    std::string line;
    append_kitti_line(line, pose);
    std::string expected;
    for (int i = 0; i < 12; ++i) {
      char digits[32];
      std::snprintf(digits, sizeof digits, "%.9e", i % 4 == 3 ? pose.t(i / 4) : pose.R(i / 4, i % 4));
      expected += digits + std::string(i == 11 ? "\n" : " ");
    }
    EXPECT_EQ(line, expected);
  }
}

TEST(KittiPoses, ComeBackAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  const Trajectory path = random_path(100, 2);
  write_kitti_poses(folder.file("a"), path);
  const Trajectory again = read_kitti_poses(folder.file("a"));
  ASSERT_EQ(again.T_w_c.size(), path.T_w_c.size());
  for (std::size_t i = 0; i < path.T_w_c.size(); ++i) {
    EXPECT_TRUE(again.T_w_c[i].R.isApprox(path.T_w_c[i].R, 1e-9));
    EXPECT_TRUE(again.T_w_c[i].t.isApprox(path.T_w_c[i].t, 1e-9));
  }
  write_kitti_poses(folder.file("b"), again);
  EXPECT_EQ(test::bytes_of(folder.file("a")), test::bytes_of(folder.file("b")));
}

TEST(KittiPoses, OfTheRecordedSequencesAreRead) {
  PAVO_NEEDS_DATA("sequences/kitti05-300/poses.txt");
  EXPECT_EQ(read_kitti_poses((test::data_folder() / "sequences/kitti05-300/poses.txt").string()).T_w_c.size(), 300u);
  EXPECT_EQ(read_times((test::data_folder() / "sequences/kitti05-300/times.txt").string()).size(), 300u);
}

TEST(KittiTimes, AreExactAndMustIncrease) {
  EXPECT_EQ(parse_times("0.000000e+00\n1.042283e-01\r\n2\n\n", "t"),
            (std::vector<std::int64_t>{0, 104'228'300, 2'000'000'000}));
  EXPECT_THAT(complaint([] { parse_times("0\n2\n1\n", "times.txt"); }),
              StartsWith("times.txt:3: the time '1' does not come after"));
  EXPECT_THAT(complaint([] { parse_times("0\n0\n", "times.txt"); }), StartsWith("times.txt:2: "));
  EXPECT_THAT(complaint([] { parse_times("0\nNaN\n", "times.txt"); }), StartsWith("times.txt:2: expected a finite"));
  EXPECT_THAT(complaint([] { parse_times("0 1\n", "times.txt"); }), StartsWith("times.txt:1: expected 1 number"));
  EXPECT_THAT(complaint([] { parse_times("1403715273262142976\n", "times.txt"); }), HasSubstr("expected seconds"));
  EXPECT_THAT(complaint([] { parse_times("", "times.txt"); }), HasSubstr("no time in it"));
}

}  // namespace
}  // namespace pavo
