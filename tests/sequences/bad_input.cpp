// Directories that are no sequence, or a broken one: one line that says what was looked for, and where it is wrong.
#include <sys/stat.h>
#include <unistd.h>

#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;

TEST(BadInput, NothingThere) {
  EXPECT_THAT(open_error("/no/such/folder"), HasSubstr("/no/such/folder: does not exist"));
  EXPECT_THAT(open_error(""), HasSubstr("does not exist"));
  EXPECT_THAT(open_error("/dev/null"), HasSubstr("/dev/null: is neither a directory nor a regular file"));
}

TEST(BadInput, AnEmptyDirectory) {
  TemporaryFolder folder;
  EXPECT_THAT(open_error(folder.string()), HasSubstr("is empty: expected a recorded sequence"));
}

TEST(BadInput, ADirectoryOfSomethingElse) {
  TemporaryFolder folder;
  folder.write("notes.txt", "nothing");
  EXPECT_THAT(open_error(folder.string()),
              AllOf(HasSubstr("no recorded sequence recognised"), HasSubstr("KITTI odometry"),
                    HasSubstr("mav0/cam0/data.csv"), HasSubstr("rgb.txt"), HasSubstr("images")));
}

TEST(BadInput, ASequenceWithoutImages) {
  TemporaryFolder folder;
  write_kitti(folder, 1);
  std::filesystem::remove(folder / "image_0/000000.pgm");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("image_0: has no images"));
}

TEST(BadInput, ASingleImage) {
  TemporaryFolder folder;
  folder.write("a.png", "x");
  EXPECT_THAT(open_error((folder / "a.png").string()), HasSubstr("a.png: is a single image: expected its folder"));
}

TEST(BadInput, AFileThatIsNoVideo) {
  TemporaryFolder folder;
  folder.write("a.mp4", "no video at all");
  EXPECT_THAT(open_error((folder / "a.mp4").string()), HasSubstr("a.mp4: is no video"));
  folder.write("b.mp4", "");
  EXPECT_THAT(open_error((folder / "b.mp4").string()), HasSubstr("b.mp4: is no video"));
}

TEST(BadInput, TimesShorterThanTheImages) {
  TemporaryFolder folder;
  write_kitti(folder, 3);
  folder.write("times.txt", "0\n0.1\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("times.txt: has 2 times for 3 images"));
}

TEST(BadInput, TimesThatRunBackwards) {
  TemporaryFolder folder;
  write_kitti(folder, 3);
  folder.write("times.txt", "0\n0.2\n0.1\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("times.txt:3: "));
  folder.write("times.txt", "0\n0.1\n0.1\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("times.txt:3: "));
}

TEST(BadInput, TimesThatAreNone) {
  TemporaryFolder folder;
  write_kitti(folder, 2);
  for (const char* times : {"0\nnan\n", "0\nsoon\n", "0\n1e300\n", "0\n0.1 0.2\n"}) {
    folder.write("times.txt", times);
    EXPECT_THAT(open_error(folder.string()), HasSubstr("times.txt:2: ")) << times;
  }
}

TEST(BadInput, MalformedPoses) {
  TemporaryFolder folder;
  write_kitti(folder, 2);
  for (const char* poses :
       {"1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1\n", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 nan 0 1 0 0 0 0 1 0\n"}) {
    folder.write("poses.txt", poses);
    EXPECT_THAT(open_error(folder.string()), HasSubstr("poses.txt:2: ")) << poses;
    SequenceOptions without;
    without.groundtruth = "none";
    EXPECT_NO_THROW(open_sequence(folder.string(), without)) << "what is not asked for is not read";
  }
}

TEST(BadInput, Calibrations) {
  TemporaryFolder folder;
  write_kitti(folder, 2);
  folder.write("calib.txt", "P0: nan 0 32 0 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("calib.txt:1: P0 has 'nan'"));
  folder.write("calib.txt", "P0: 707 0 602 0 0 707 183 0 0 0 1 0\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("far outside the image of 64x48"));
  SequenceOptions options;
  options.calibration = (folder / "nowhere.yaml").string();
  EXPECT_THAT(open_error(folder.string(), options), HasSubstr("nowhere.yaml"));
  folder.write("other.yaml",
               "image_width: 640\nimage_height: 480\nK: [500, 0, 320, 0, 500, 240, 0, 0, 1]\nD: [0, 0, 0, 0]\n");
  options.calibration = (folder / "other.yaml").string();
  EXPECT_THAT(open_error(folder.string(), options),
              AllOf(HasSubstr("is for images of 640x480"), HasSubstr("000000.pgm has 64x48")));
}

TEST(BadInput, GivenGroundTruth) {
  TemporaryFolder folder;
  write_kitti(folder, 2);
  SequenceOptions options;
  options.groundtruth = (folder / "nowhere.txt").string();
  EXPECT_THAT(open_error(folder.string(), options), HasSubstr("nowhere.txt"));
  folder.write("truth.txt", "1 2 3\n");
  options.groundtruth = (folder / "truth.txt").string();
  EXPECT_THAT(open_error(folder.string(), options), HasSubstr("truth.txt:1: "));
  folder.write("truth.txt", "1403715273000000000,5,6,7,1,0,0,0\n");
  EXPECT_THAT(open_error(folder.string(), options), HasSubstr("is of the body"));
  folder.write("truth.txt", "0 0 0 0 0 0 0 1\n");
  std::filesystem::remove(folder / "times.txt");
  EXPECT_THAT(open_error(folder.string(), options), HasSubstr("goes by time, and the frames have none"));
}

/// root may read everything: as long as this lives, the process is nobody.
class WithoutPrivileges {
 public:
  WithoutPrivileges() : was_root_(::geteuid() == 0) {
    if (was_root_ && ::seteuid(65534) != 0) throw std::runtime_error("seteuid");
  }
  ~WithoutPrivileges() {
    if (was_root_ && ::seteuid(0) != 0) std::abort();
  }

 private:
  bool was_root_;
};

TEST(BadInput, NoPermission) {
  TemporaryFolder folder;
  write_kitti(folder, 3);
  ::chmod(folder.path().c_str(), 0755);
  ::chmod((folder / "image_0/000001.pgm").c_str(), 0);
  {
    const WithoutPrivileges nobody;
    const auto frames = read_all(*open_sequence(folder.string()));
    EXPECT_THAT(frames[1].error, HasSubstr("000001.pgm: cannot be read: Permission denied"));
    EXPECT_EQ(frames[2].error, "");
  }
  ::chmod((folder / "times.txt").c_str(), 0);
  {
    const WithoutPrivileges nobody;
    EXPECT_THAT(open_error(folder.string()), AllOf(HasSubstr("times.txt"), HasSubstr("Permission denied")));
  }
  ::chmod((folder / "image_0").c_str(), 0);
  {
    const WithoutPrivileges nobody;
    EXPECT_THAT(open_error(folder.string()), AllOf(HasSubstr("image_0"), HasSubstr("Permission denied")));
  }
  ::chmod(folder.path().c_str(), 0);
  {
    const WithoutPrivileges nobody;
    EXPECT_THAT(open_error(folder.string()), HasSubstr("Permission denied"));
    EXPECT_THAT(open_error((folder / "image_0").string()), HasSubstr("Permission denied"));
  }
  ::chmod(folder.path().c_str(), 0700);
  ::chmod((folder / "image_0").c_str(), 0700);
}

}  // namespace
}  // namespace pavo
