// KITTI raw's GPS/IMU records ("oxts") as poses.
#pragma once

#include <string>
#include <string_view>

#include "types/pose.h"

namespace pavo {

/// What a pose needs of one record: the first 6 of its 30 numbers.
struct OxtsRecord {
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
  double roll_rad = 0, pitch_rad = 0, yaw_rad = 0;
};

/// Throws std::runtime_error("NAME:1: ...") where it is no record.
OxtsRecord parse_oxts(std::string_view text, const std::string& name);

/// T_w_imu as KITTI's devkit has it (convertOxtsToPose.m, after Geiger et al., IJRR 2013): the Mercator projection of
/// the Earth as a sphere of 6378137 m, scaled by the cosine of the first record's latitude; x east, y north, z up; R =
/// Rz(yaw) Ry(pitch) Rx(roll); the IMU looks along x, y left, z up.
SE3 imu_pose(const OxtsRecord& record, double first_latitude_deg);

}  // namespace pavo
