#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using testing::HasSubstr;

// The camera is 1 m ahead of the body along the body's x, and looks that way: z of the camera is x of the body.
const std::string kSensor = R"(sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0, 0, 1, 1,
         -1, 0, 0, 0,
         0, -1, 0, 0,
         0, 0, 0, 1]
resolution: [64, 48]
camera_model: pinhole
intrinsics: [50, 50, 32, 24]
distortion_model: radial-tangential
distortion_coefficients: [0.1, 0, 0, 0]
)";

void write_euroc(const TemporaryFolder& folder) {
  std::string index = "#timestamp [ns],filename\r\n";
  for (int i = 0; i < 4; ++i) {
    const std::string name = "140371527326214297" + std::to_string(i) + ".pgm";
    folder.write("mav0/cam0/data/" + name, pgm(64, 48, static_cast<char>('a' + i)));
    index += std::to_string(1403715273'000000000 + i * 50'000'000) + ", " + name + "\r\n";
  }
  folder.write("mav0/cam0/data.csv", index);
  folder.write("mav0/cam0/sensor.yaml", kSensor);
}

// The body turns about its z by 90 degrees from 0 ms to 100 ms, without moving.
const std::string kTruth =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
    "1403715273000000000,5,6,7,1,0,0,0,0.1,0.2,0.3\n"
    "1403715273100000000,5,6,7,0.70710678118654757,0,0,0.70710678118654757,0.1,0.2,0.3\n";

TEST(Euroc, FramesAndCalibrationFromAnyOfItsFolders) {
  TemporaryFolder folder;
  write_euroc(folder);
  for (const char* given : {"", "mav0", "mav0/cam0", "mav0/cam0/"}) {
    const auto sequence = open_sequence((folder / given).string());
    EXPECT_EQ(sequence->info().layout, "EuRoC");
    EXPECT_EQ(sequence->info().camera->lens, Lens::radial_tangential);
    const auto frames = read_all(*sequence);
    ASSERT_EQ(frames.size(), 4);
    EXPECT_EQ(frames[3].stamp.t_capture_ns, 1403715273'150000000) << "to the nanosecond";
    EXPECT_EQ(frames[3].bytes, pgm(64, 48, 'd'));
  }
}

/// T_w_c = T_w_b T_b_c: the camera, 1 m off the axis, swings on a circle; interpolated at 50 ms, and none at 150 ms.
TEST(Euroc, TruthOfTheBodyBecomesTheCameras) {
  TemporaryFolder folder;
  write_euroc(folder);
  folder.write("mav0/state_groundtruth_estimate0/data.csv", kTruth);
  const auto sequence = open_sequence(folder.string());
  const SequenceInfo& info = sequence->info();
  ASSERT_TRUE(info.groundtruth) << info.groundtruth_source;
  EXPECT_EQ(info.groundtruth_frames, (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_THAT(info.groundtruth_source, HasSubstr("covers 3 of the 4 frames"));
  // The body turns left; in the first camera's frame left is -x and ahead is z.
  const auto& poses = info.groundtruth->T_w_c;
  EXPECT_LT((poses[2].t - Eigen::Vector3d(-1, 0, -1)).norm(), 1e-12) << poses[2].t.transpose();
  EXPECT_LT((poses[2].R * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);
  // Half way: 45 degrees (the poses of the camera are interpolated along the chord).
  EXPECT_LT((poses[1].R * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(-std::sqrt(0.5), 0, std::sqrt(0.5))).norm(),
            1e-12);
}

TEST(Euroc, ATumFileBesideIsOfTheBodyToo) {
  TemporaryFolder folder;
  write_euroc(folder);
  folder.write("groundtruth.tum",
               "# t x y z q\n1403715273.0 5 6 7 0 0 0 1\n1403715273.1 5 6 7 0 0 0.70710678 0.70710678\n");
  for (const std::string& named : {std::string(), (folder / "groundtruth.tum").string()}) {
    SequenceOptions options;
    options.groundtruth = named;
    const auto sequence = open_sequence(folder.string(), options);
    ASSERT_TRUE(sequence->info().groundtruth);
    EXPECT_LT((sequence->info().groundtruth->T_w_c[2].t - Eigen::Vector3d(-1, 0, -1)).norm(), 1e-7);
  }
}

TEST(Euroc, WithoutThePlaceInTheBodyThereIsNoTruth) {
  TemporaryFolder folder;
  write_euroc(folder);
  folder.write("mav0/state_groundtruth_estimate0/data.csv", kTruth);
  folder.write("mav0/cam0/sensor.yaml", "resolution: [64, 48]\nintrinsics: [50, 50, 32, 24]\ndistortion_model: none\n");
  const auto sequence = open_sequence(folder.string());
  EXPECT_FALSE(sequence->info().groundtruth);
  EXPECT_THAT(sequence->info().groundtruth_source, HasSubstr("T_BS"));
}

TEST(Euroc, AnotherCalibrationKeepsThePlaceInTheBody) {
  TemporaryFolder folder;
  write_euroc(folder);
  folder.write("mav0/state_groundtruth_estimate0/data.csv", kTruth);
  folder.write("mine.txt", kKittiCalibration);
  SequenceOptions options;
  options.calibration = (folder / "mine.txt").string();
  const auto sequence = open_sequence(folder.string(), options);
  EXPECT_EQ(sequence->info().camera->lens, Lens::rectified);
  EXPECT_TRUE(sequence->info().groundtruth);
}

TEST(Euroc, AListedImageThatIsMissingFailsItsFrame) {
  TemporaryFolder folder;
  write_euroc(folder);
  std::filesystem::remove(folder / "mav0/cam0/data/1403715273262142971.pgm");
  const auto frames = read_all(*open_sequence(folder.string()));
  ASSERT_EQ(frames.size(), 4);
  EXPECT_THAT(frames[1].error, HasSubstr("1403715273262142971.pgm: cannot be read"));
  EXPECT_EQ(frames[2].error, "");
}

TEST(Euroc, RefusesMalformedIndexAndTruth) {
  TemporaryFolder folder;
  write_euroc(folder);
  folder.write("mav0/state_groundtruth_estimate0/data.csv", "#\n1403715273000000000,5,6,nan,1,0,0,0\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("state_groundtruth_estimate0/data.csv:2: "));
  folder.write("mav0/cam0/data.csv", "#timestamp\n100,a.png\n100,b.png\n");
  EXPECT_THAT(open_error(folder.string()),
              HasSubstr("cam0/data.csv:3: the time does not come after the one before it"));
  folder.write("mav0/cam0/data.csv", "#timestamp\n1403715273.1,a.png\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("cam0/data.csv:2: expected 'nanoseconds,file'"));
  folder.write("mav0/cam0/data.csv", "#timestamp [ns],filename\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("cam0/data.csv: lists no frame"));
}

}  // namespace
}  // namespace pavo
