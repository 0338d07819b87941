#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "drivers/sequences/oxts.h"
#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using Eigen::AngleAxisd;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kLatitude = 49.015, kLongitude = 8.43;
constexpr double kMetresPerDegree = 6378137.0 * std::numbers::pi / 180;

/// A record at `east` and `north` metres from the first, to first order.
std::string oxts(double east, double north, double up, double roll, double pitch, double yaw) {
  char text[400];
  std::snprintf(text, sizeof text,
                "%.14f %.14f %.9f %.12f %.12f %.12f 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 4 10 4 4",
                kLatitude + north / kMetresPerDegree,
                kLongitude + east / (kMetresPerDegree * std::cos(kLatitude * std::numbers::pi / 180)), 110 + up, roll,
                pitch, yaw);
  return text;
}

std::string text(const Eigen::Matrix3d& R) {
  std::string result;
  for (int i = 0; i < 9; ++i) {
    char number[40];
    std::snprintf(number, sizeof number, " %.15f", R(i / 3, i % 3));
    result += number;
  }
  return result;
}

const SE3 kVeloFromImu{AngleAxisd(0.01, Vector3d::UnitZ()).toRotationMatrix(), {-0.81, 0.32, -0.80}};
/// Camera axes (x right, y down, z forward) from the laser's (x forward, y left, z up).
const SE3 kCameraFromVelo{(Eigen::Matrix3d() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished(), {-0.004, -0.076, -0.27}};
const Eigen::Matrix3d kRectification = AngleAxisd(0.02, Vector3d::UnitX()).toRotationMatrix();

struct Drive {
  TemporaryFolder folder;
  std::string path = (folder / "2011_09_26/2011_09_26_drive_0001_sync").string();

  explicit Drive(const std::vector<std::string>& records, int camera = 0) {
    const std::string drive = "2011_09_26/2011_09_26_drive_0001_sync/", n = std::to_string(camera);
    std::string stamps;
    for (std::size_t i = 0; i < records.size(); ++i) {
      const std::string name = "000000000" + std::to_string(i);
      folder.write(drive + "image_0" + n + "/data/" + name + ".pgm", pgm(64, 48, 'x'));
      folder.write(drive + "oxts/data/" + name + ".txt", records[i] + "\n");
      stamps += "2011-09-26 13:02:25." + std::to_string(100 + 100 * i) + "360375\n";
    }
    folder.write(drive + "image_0" + n + "/timestamps.txt", stamps);
    const std::string day = "2011_09_26/";
    folder.write(day + "calib_imu_to_velo.txt",
                 "calib_time: 25-May-2012 16:47:16\nR:" + text(kVeloFromImu.R) + "\nT: -0.81 0.32 -0.80\n");
    folder.write(day + "calib_velo_to_cam.txt", "calib_time: 15-Mar-2012 11:37:16\nR:" + text(kCameraFromVelo.R) +
                                                    "\nT: -0.004 -0.076 -0.27\ndelta_f: 0 0\ndelta_c: 0 0\n");
    // Camera n is 0.5 m to the right of camera 0: P = K [I | (-0.5, 0, 0)].
    folder.write(day + "calib_cam_to_cam.txt", "calib_time: 09-Jan-2012 13:57:47\nR_rect_00:" + text(kRectification) +
                                                   "\nS_rect_0" + n + ": 64 48\nP_rect_0" + n + ": 50 0 32 " +
                                                   (camera ? "-25" : "0") + " 0 50 24 0 0 0 1 0\n");
  }
};

SE3 camera_from_imu(int camera) {
  const SE3 shifted{kRectification, {camera ? -0.5 : 0.0, 0, 0}};
  return shifted * kCameraFromVelo * kVeloFromImu;
}

TEST(KittiRaw, FramesTimesAndCalibrationOneFolderUp) {
  const Drive drive({oxts(0, 0, 0, 0, 0, 0), oxts(1, 0, 0, 0, 0, 0)}, 2);
  const auto sequence = open_sequence(drive.path);
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.layout, "KITTI raw");
  EXPECT_EQ(info.camera->fx, 50);
  EXPECT_EQ(info.camera->width, 64);
  EXPECT_THAT(info.calibration_source, HasSubstr("calib_cam_to_cam.txt, P_rect_02"));
  const auto frames = read_all(*sequence);
  ASSERT_EQ(frames.size(), 2);
  EXPECT_EQ(frames[0].stamp.t_capture_ns, 1317042145'100360375) << "date -u -d '2011-09-26 13:02:25' +%s";
  EXPECT_EQ(frames[1].stamp.t_capture_ns, 1317042145'200360375);
  EXPECT_EQ(open_sequence(drive.path + "/image_02")->info().layout, "KITTI raw");
}

/// The car drives east, then turns by 90 degrees to the north, over a bump. What the camera does follows from the IMU's
/// pose and the lever arm: T_w_c = T_c0_w ... = X T_imu0_imu X^-1 with X = T_c_imu.
TEST(KittiRaw, TruthIsTheImusMotionSeenByTheCamera) {
  for (const int camera : {0, 2}) {
    const double turn = std::numbers::pi / 2;
    const Drive drive({oxts(0, 0, 0, 0, 0, 0), oxts(4, 0, 0, 0, 0, 0), oxts(9, 3, 0.5, 0.01, -0.02, turn)}, camera);
    const auto sequence = open_sequence(drive.path);
    ASSERT_TRUE(sequence->info().groundtruth) << sequence->info().groundtruth_source;
    const auto& poses = sequence->info().groundtruth->T_w_c;
    ASSERT_EQ(poses.size(), 3);
    const SE3 X = camera_from_imu(camera);
    const Eigen::Matrix3d R = (AngleAxisd(turn, Vector3d::UnitZ()) * AngleAxisd(-0.02, Vector3d::UnitY()) *
                               AngleAxisd(0.01, Vector3d::UnitX()))
                                  .toRotationMatrix();
    const SE3 motions[] = {{}, {Eigen::Matrix3d::Identity(), {4, 0, 0}}, {R, {9, 3, 0.5}}};
    for (std::size_t i = 0; i < 3; ++i) {
      const SE3 expected = X * motions[i] * X.inverse();
      EXPECT_LT((poses[i].R - expected.R).norm(), 1e-9) << i;
      EXPECT_LT((poses[i].t - expected.t).norm(), 1e-3) << i;  // Mercator's map is not flat
    }
    EXPECT_EQ(poses[0].t, Vector3d::Zero());
    EXPECT_NEAR(poses[1].t.norm(), 4, 1e-5);
    EXPECT_GT(poses[1].t.z(), 3.9) << "forward";
  }
}

TEST(KittiRaw, WithoutTheCalibrationsOfImuAndLaserThereIsNoTruth) {
  const Drive drive({oxts(0, 0, 0, 0, 0, 0), oxts(1, 0, 0, 0, 0, 0)});
  std::filesystem::remove(drive.folder / "2011_09_26/calib_imu_to_velo.txt");
  const auto sequence = open_sequence(drive.path);
  EXPECT_FALSE(sequence->info().groundtruth);
  EXPECT_THAT(sequence->info().groundtruth_source, HasSubstr("none: no "));
  EXPECT_THAT(sequence->info().groundtruth_source, HasSubstr("calib_imu_to_velo.txt"));
}

TEST(KittiRaw, AMissingRecordIsAHoleInTheTruth) {
  const Drive drive({oxts(0, 0, 0, 0, 0, 0), oxts(1, 0, 0, 0, 0, 0), oxts(2, 0, 0, 0, 0, 0)});
  std::filesystem::remove(std::filesystem::path(drive.path) / "oxts/data/0000000001.txt");
  const auto sequence = open_sequence(drive.path);
  EXPECT_EQ(sequence->info().groundtruth_frames, (std::vector<std::int64_t>{0, 2}));
  EXPECT_NEAR(sequence->info().groundtruth->T_w_c[1].t.norm(), 2, 1e-5);
}

TEST(KittiRaw, ACutOfADriveTakesItsOwnRecords) {
  const Drive drive({oxts(0, 0, 0, 0, 0, 0), oxts(1, 0, 0, 0, 0, 0), oxts(3, 0, 0, 0, 0, 0), oxts(7, 0, 0, 0, 0, 0)});
  std::filesystem::remove(std::filesystem::path(drive.path) / "oxts/timestamps.txt");
  for (const int i : {0, 1})
    std::filesystem::remove(std::filesystem::path(drive.path) /
                            ("image_00/data/000000000" + std::to_string(i) + ".pgm"));
  const auto sequence = open_sequence(drive.path);
  ASSERT_EQ(sequence->info().groundtruth_frames.size(), 2);
  EXPECT_NEAR(sequence->info().groundtruth->T_w_c[1].t.norm(), 4, 1e-5);
}

TEST(KittiRaw, RecordsAtTheirOwnRateGoByTime) {
  const Drive drive({oxts(0, 0, 0, 0, 0, 0), oxts(1, 0, 0, 0, 0, 0)});
  const std::string oxts_folder = "2011_09_26/2011_09_26_drive_0001_sync/oxts/";
  std::string stamps;
  for (int i = 0; i < 5; ++i) {
    drive.folder.write(oxts_folder + "data/000000000" + std::to_string(i) + ".txt", oxts(2.0 * i, 0, 0, 0, 0, 0));
    stamps += "2011-09-26 13:02:25." + std::to_string(100 + 50 * i) + "360375\n";
  }
  drive.folder.write(oxts_folder + "timestamps.txt", stamps);
  const auto sequence = open_sequence(drive.path);
  ASSERT_EQ(sequence->info().groundtruth_frames.size(), 2);
  EXPECT_NEAR(sequence->info().groundtruth->T_w_c[1].t.norm(), 4, 1e-4) << "0.1 s are two records";
}

TEST(KittiRaw, ImuPoseIsMercators) {
  // A degree of longitude at the first record's latitude has its true length; one of latitude too, near it.
  const OxtsRecord a{kLatitude, kLongitude, 0, 0, 0, 0}, b{kLatitude, kLongitude + 0.001, 0, 0, 0, 0},
      c{kLatitude + 0.001, kLongitude, 0, 0, 0, 0};
  const Vector3d east = imu_pose(b, kLatitude).t - imu_pose(a, kLatitude).t,
                 north = imu_pose(c, kLatitude).t - imu_pose(a, kLatitude).t;
  EXPECT_NEAR(east.x(), 0.001 * kMetresPerDegree * std::cos(kLatitude * std::numbers::pi / 180), 1e-6);
  EXPECT_NEAR(east.y(), 0, 1e-6);
  EXPECT_NEAR(north.y(), 0.001 * kMetresPerDegree, 2e-3);
  EXPECT_NEAR(north.x(), 0, 1e-6);
}

TEST(KittiRaw, RefusesRecordsThatAreNone) {
  for (const char* record : {"", "49 8 110 0 0", "49 8 nan 0 0 0", "91 8 110 0 0 0", "49 8 110 0 0 north"}) {
    EXPECT_THAT(error_of([&] { parse_oxts(record, "0000000000.txt"); }), HasSubstr("0000000000.txt:1: ")) << record;
  }
}

}  // namespace
}  // namespace pavo
