// TUM's trajectory files, and that a file's format is recognised from its first pose.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <random>

#include "drivers/trajectories/trajectory_files.h"
#include "tests/support/data.h"
#include "tests/support/temporary.h"

namespace pavo {
namespace {

using test::complaint;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string tum_refusal(const std::string& text) {
  return complaint([&] { parse_tum(text, "path.tum"); });
}

TEST(TumFiles, ReadTimePositionAndQuaternion) {
  const Trajectory path = parse_tum(
      "# timestamp tx ty tz qx qy qz qw\n\n 1.5 1 2 3 0 0 0.70710678 0.70710678\r\n\n2 0 0 0 0 0 0 -1\n", "p");
  ASSERT_EQ(path.T_w_c.size(), 2u);
  EXPECT_EQ(path.t_ns, (std::vector<std::int64_t>{1'500'000'000, 2'000'000'000}));
  EXPECT_EQ(path.T_w_c[0].t, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE((path.T_w_c[0].R * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-8));
  EXPECT_TRUE(path.T_w_c[1].R.isIdentity(1e-15));
}

TEST(TumFiles, KeepNanosecondsOfToday) {
  EXPECT_EQ(parse_tum("1403715273.262142976 0 0 0 0 0 0 1\n", "p").t_ns[0], 1'403'715'273'262'142'976);
  EXPECT_EQ(parse_tum("1.403715273262142976e+09 0 0 0 0 0 0 1\n", "p").t_ns[0], 1'403'715'273'262'142'976);
  std::string line;
  append_tum_line(line, 1'403'715'273'000'000'001, {});
  EXPECT_THAT(line, StartsWith("1403715273.000000001 "));
  line.clear();
  append_tum_line(line, -1'500'000'000, {});
  EXPECT_THAT(line, StartsWith("-1.500000000 "));
}

TEST(TumFiles, NameTheLineOfWhatIsWrong) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  EXPECT_THAT(tum_refusal(good + "2 0 0 0 0 0 1\n"), StartsWith("path.tum:2: expected 8 numbers"));
  EXPECT_THAT(tum_refusal("# x\n" + good + "2 nan 0 0 0 0 0 1\n"), StartsWith("path.tum:3: expected a finite number"));
  EXPECT_THAT(tum_refusal(good + "0.5 0 0 0 0 0 0 1\n"), StartsWith("path.tum:2: the time '0.5' does not come after"));
  EXPECT_THAT(tum_refusal(good + good), StartsWith("path.tum:2: the time '1' does not come after"));
  EXPECT_THAT(tum_refusal("1 0 0 0 0 0 0 0\n"), HasSubstr("no unit quaternion"));
  EXPECT_THAT(tum_refusal("1 0 0 0 1 0 0 1\n"), HasSubstr("no unit quaternion"));
  EXPECT_THAT(tum_refusal("inf 0 0 0 0 0 0 1\n"), StartsWith("path.tum:1: expected a finite number"));
  EXPECT_THAT(tum_refusal("1403715273262142976 0 0 0 0 0 0 1\n"), HasSubstr("expected seconds"));
  EXPECT_THAT(tum_refusal("1 0 1e10 0 0 0 0 1\n"), HasSubstr("1e9 m"));
  EXPECT_THAT(tum_refusal("# nothing\n"), StartsWith("path.tum: no pose in it"));
}

TEST(TumFiles, ComeBackAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Trajectory path;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q(uniform(random), uniform(random), uniform(random), uniform(random));
    path.T_w_c.push_back({q.normalized().toRotationMatrix(), Eigen::Vector3d(uniform(random), 1e-5, 1e4 * i)});
    path.t_ns.push_back(1'403'715'273'262'142'976 + i * 49'999'999LL);
  }
  write_tum(folder.file("path.tum"), path);
  const Trajectory again = read_tum(folder.file("path.tum"));
  EXPECT_EQ(again.t_ns, path.t_ns);
  for (std::size_t i = 0; i < path.T_w_c.size(); ++i) {
    EXPECT_TRUE(again.T_w_c[i].R.isApprox(path.T_w_c[i].R, 1e-8)) << i;
    EXPECT_TRUE(again.T_w_c[i].t.isApprox(path.T_w_c[i].t, 1e-9)) << i;
  }
}

TEST(TumFiles, NeedATimePerPose) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(write_tum(folder.file("path.tum"), {{SE3{}}, {}}), std::invalid_argument);
}

TEST(TrajectoryFiles, AreRecognisedByTheirFirstPose) {
  EXPECT_TRUE(parse_trajectory("1 0 0 0 0 1 0 0 0 0 1 0\n", "p").t_ns.empty());
  EXPECT_EQ(parse_trajectory("# a comment of twelve words that is not to be taken for a pose\n\n1 0 0 0 0 0 0 1\n", "p")
                .t_ns.size(),
            1u);
  EXPECT_THAT(complaint([] { parse_trajectory("1 2 3\n", "p"); }),
              StartsWith("p:1: expected 12 numbers (KITTI) or 8 (TUM)"));
  EXPECT_THAT(complaint([] { parse_trajectory("# x\n", "p"); }), StartsWith("p: no pose in it"));
}

TEST(TrajectoryFiles, ThatCannotBeReadAreNamedWithTheReason) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(complaint([&] { read_trajectory(folder.file("none")); }),
            folder.file("none") + ": cannot be read: No such file or directory");
  EXPECT_THAT(complaint([&] { read_trajectory(folder.file("")); }), HasSubstr("Is a directory"));
  EXPECT_THAT(complaint([] { read_whole_file("/dev/zero", 100'000); }), HasSubstr("/dev/zero: more than 100000 bytes"));
}

TEST(TrajectoryFiles, OfAnyBytesGiveAPathOrAComplaint) {
  std::mt19937 random(4);
  const std::string alphabet = "0123456789.eE+-# \t\r\n\n  nainf\xff";
  const std::string line = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 0 0 1\n";
  for (int round = 0; round < 3000; ++round) {
    std::string text = line + line;
    for (unsigned change = 0; change < 1 + random() % 8; ++change)
      text[random() % text.size()] = alphabet[random() % alphabet.size()];
    text.resize(random() % (text.size() + 1));
    for (const auto parse : {parse_trajectory, parse_kitti_poses, parse_tum}) {
      complaint([&] {
        for (const SE3& pose : parse(text, "fuzz").T_w_c) EXPECT_TRUE(pose.t.allFinite() && pose.R.allFinite());
      });
    }
  }
}

TEST(TumFiles, OfTheRecordedSequencesAreRead) {
  PAVO_NEEDS_DATA("sequences/euroc-standstill-25/groundtruth.tum");
  EXPECT_EQ(
      read_trajectory((test::data_folder() / "sequences/euroc-standstill-25/groundtruth.tum").string()).t_ns.size(),
      58u);
}

}  // namespace
}  // namespace pavo
