// Files that grow during a run: what was written stays, what could not be written is told.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "drivers/trajectories/append_file.h"
#include "drivers/trajectories/trajectory_files.h"
#include "tests/support/temporary.h"

namespace pavo {
namespace {

using test::bytes_of;
using test::complaint;
using ::testing::EndsWith;
using ::testing::HasSubstr;

TEST(GrowingFiles, HaveEachLineAtOnce) {
  const test::TemporaryFolder folder;
  KittiWriter writer(folder.file("trajectory.kitti"));
  for (std::size_t i = 1; i <= 3; ++i) {
    writer.write({Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, static_cast<double>(i))});
    EXPECT_EQ(read_kitti_poses(folder.file("trajectory.kitti")).T_w_c.size(), i) << "before close";
  }
  writer.close();
  writer.close();
  EXPECT_THROW(writer.write({}), std::logic_error);
}

TEST(GrowingFiles, OutliveAProcessThatIsKilled) {
  const test::TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    TumWriter writer(folder.file("trajectory.tum"));
    for (int i = 0; i < 100; ++i) writer.write(i, {});
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(read_tum(folder.file("trajectory.tum")).T_w_c.size(), 100u);
}

TEST(GrowingFiles, TellOfAFullDisk) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  KittiWriter kitti("/dev/full");
  EXPECT_EQ(complaint([&] { kitti.write({}); }), "/dev/full: writing failed: No space left on device");
  TumWriter tum("/dev/full");
  EXPECT_EQ(complaint([&] { tum.write(0, {}); }), "/dev/full: writing failed: No space left on device");
  EXPECT_EQ(complaint([] { write_whole_file("/dev/full", "x"); }),
            "/dev/full: writing failed: No space left on device");
}

/// The kernel takes a part of the line that does not fit; a limit on the file's size does the same as a full disk.
TEST(GrowingFiles, EndWithAWholeLineWhereTheDiskFillsUp) {
  const test::TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{25, 25};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    AppendFile file(folder.file("a"));
    file.append("first line\n");
    file.append("second one\n");
    const std::string text = complaint([&] { file.append("the third does not fit\n"); });
    ::_exit(text.ends_with("/a: writing failed: File too large") ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(bytes_of(folder.file("a")), "first line\nsecond one\n");
}

TEST(GrowingFiles, ThatCannotBeOpenedAreNamedWithTheReason) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(complaint([&] { KittiWriter{folder.file("no/such/folder")}; }),
            folder.file("no/such/folder") + ": cannot be written: No such file or directory");
  EXPECT_THAT(complaint([&] { AppendFile{folder.file("")}; }), HasSubstr("Is a directory"));
}

TEST(WholeFiles, ReplaceTheOldOneAtOnceOrNotAtAll) {
  const test::TemporaryFolder folder;
  write_whole_file(folder.file("report.json"), "old");
  write_whole_file(folder.file("report.json"), "new");
  EXPECT_EQ(bytes_of(folder.file("report.json")), "new");
  EXPECT_FALSE(std::filesystem::exists(folder.file("report.json.part")));

  std::filesystem::create_directory(folder.file("taken"));
  EXPECT_THAT(complaint([&] { write_whole_file(folder.file("taken/x/y"), "z"); }),
              EndsWith("y: cannot be written: No such file or directory"));
  EXPECT_THAT(complaint([&] { write_whole_file(folder.file("taken"), "z"); }),
              EndsWith("taken: cannot be written: Is a directory"));
}

TEST(WholeFiles, ComeBackToTheByte) {
  const test::TemporaryFolder folder;
  std::string bytes(200'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7);
  write_whole_file(folder.file("a"), bytes);
  EXPECT_EQ(read_whole_file(folder.file("a")), bytes);
}

}  // namespace
}  // namespace pavo
