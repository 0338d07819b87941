#include "drivers/sequences/directory.h"
#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(ImageFolder, InNaturalOrder) {
  TemporaryFolder folder;
  for (const char* name : {"frame10.PGM", "frame9.pgm", "frame1.pgm", ".hidden.png", "notes.txt", "frame9.pgm.bak"}) {
    folder.write(name, pgm(8, 6, 'x'));
  }
  const auto sequence = open_sequence(folder.string());
  EXPECT_EQ(sequence->info().layout, "images");
  EXPECT_FALSE(sequence->info().has_times);
  const auto frames = read_all(*sequence);
  ASSERT_EQ(frames.size(), 3);
  EXPECT_EQ(frames[0].stamp.name, "frame1.pgm");
  EXPECT_EQ(frames[1].stamp.name, "frame9.pgm");
  EXPECT_EQ(frames[2].stamp.name, "frame10.PGM");
}

TEST(ImageFolder, InImagesWithEverythingBeside) {
  TemporaryFolder folder;
  folder.write("images/a.pgm", pgm(64, 48, 'x'));
  folder.write("images/b.pgm", pgm(64, 48, 'x'));
  folder.write("calib.txt", "P0: 50 0 32 0 0 50 24 0 0 0 1 0\n");
  folder.write("times.txt", "0.5\n0.75\n");
  folder.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 3\n");
  const auto sequence = open_sequence(folder.string());
  EXPECT_EQ(sequence->info().camera->fx, 50);
  EXPECT_EQ(sequence->info().groundtruth->T_w_c[1].t.z(), 3);
  EXPECT_EQ(read_all(*sequence)[1].stamp.t_capture_ns, 750'000'000);
}

TEST(ImageFolder, TwoCalibrationsAreNotChosenFrom) {
  TemporaryFolder folder;
  folder.write("a.pgm", pgm(64, 48, 'x'));
  folder.write("calib.txt", kKittiCalibration);
  folder.write("camera.yaml", "whatever");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("there is camera.yaml too, and only one can be right"));
}

TEST(ImageFolder, ARateGivesTimes) {
  TemporaryFolder folder;
  for (const char* name : {"a.pgm", "b.pgm", "c.pgm", "d.pgm"}) folder.write(name, pgm(8, 6, 'x'));
  SequenceOptions options;
  options.rate_hz = 30;
  const auto frames = read_all(*open_sequence(folder.string(), options));
  EXPECT_EQ(frames[1].stamp.t_capture_ns, 33'333'333);
  EXPECT_EQ(frames[3].stamp.t_capture_ns, 100'000'000);
  for (const double bad :
       {-1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), 1e9}) {
    options.rate_hz = bad;
    EXPECT_THAT(open_error(folder.string(), options), HasSubstr("--rate"));
  }
}

TEST(NaturalOrder, IsATotalOrder) {
  EXPECT_TRUE(natural_less("frame9", "frame10"));
  EXPECT_TRUE(natural_less("a2b10", "a2b9c") == false);
  EXPECT_TRUE(natural_less("1403715273262142976", "1403715273312143104"));
  EXPECT_TRUE(natural_less("99999999999999999999999999999998", "99999999999999999999999999999999"));
  const std::vector<std::string> names = {"",   "0",   "00",  "01", "1", "1a",   "a",     "a0",   "a00",
                                          "a1", "a01", "a10", "a2", "b", "a1b2", "a01b2", "a1b02"};
  for (const auto& a : names) {
    EXPECT_FALSE(natural_less(a, a));
    for (const auto& b : names) {
      if (a != b) {
        EXPECT_NE(natural_less(a, b), natural_less(b, a)) << a << " " << b;
      }
      for (const auto& c : names) {
        if (natural_less(a, b) && natural_less(b, c)) {
          EXPECT_TRUE(natural_less(a, c)) << a << " " << b << " " << c;
        }
      }
    }
  }
}

}  // namespace
}  // namespace pavo
