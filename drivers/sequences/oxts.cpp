#include "drivers/sequences/oxts.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "drivers/calibration/text.h"

namespace pavo {
namespace {

constexpr double kEarthRadius_m = 6378137;
constexpr double kRadians = std::numbers::pi / 180;
// Mercator's map has no poles; no car either.
constexpr double kFarthestLatitude_deg = 85;

}  // namespace

OxtsRecord parse_oxts(std::string_view text, const std::string& name) {
  const auto lines = significant_lines(text);
  const auto fields = lines.empty() ? std::vector<std::string_view>{} : split_fields(lines.front().text);
  std::array<double, 6> v{};
  if (fields.size() < v.size())
    fail_at(name, 1, "expected an oxts record: lat lon alt roll pitch yaw and 24 more numbers");
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = parse_number(fields[i]);
    if (!value || std::abs(*value) > 1e6)
      fail_at(name, 1, "has " + quoted(fields[i]) + ": expected lat lon alt roll pitch yaw");
    v[i] = *value;
  }
  if (std::abs(v[0]) > kFarthestLatitude_deg || std::abs(v[1]) > 360) {
    fail_at(name, 1, "has no position on a road: expected latitude and longitude in degrees");
  }
  return {v[0], v[1], v[2], v[3], v[4], v[5]};
}

SE3 imu_pose(const OxtsRecord& record, double first_latitude_deg) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const double scale = std::cos(first_latitude_deg * kRadians);
  SE3 pose;
  pose.t = {scale * kEarthRadius_m * record.longitude_deg * kRadians,
            scale * kEarthRadius_m * std::log(std::tan((90 + record.latitude_deg) * kRadians / 2)), record.altitude_m};
  pose.R = (AngleAxisd(record.yaw_rad, Vector3d::UnitZ()) * AngleAxisd(record.pitch_rad, Vector3d::UnitY()) *
            AngleAxisd(record.roll_rad, Vector3d::UnitX()))
               .toRotationMatrix();
  return pose;
}

}  // namespace pavo
