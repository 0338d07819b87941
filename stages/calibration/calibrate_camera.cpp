#include "stages/calibration/calibrate_camera.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <optional>
#include <stdexcept>

#include "stages/calibration/bundle.h"
#include "types/lens.h"

namespace pavo {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr const char* kMoreViews = ": take more pictures, with the board tilted to all sides and all over the image";

struct Solution {
  Camera camera;
  std::vector<BoardView> views;
  BundleResult bundle{kInfinite, {}};
};

std::vector<cv::Point3f> points_of(const Board& board) {
  std::vector<cv::Point3f> points;
  for (int i = 0; i < board.corners(); ++i) {
    const Eigen::Vector3d p = board.point(i);
    points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.f);
  }
  return points;
}

SE3 pose_of(const cv::Mat& rotation, const cv::Mat& translation) {
  cv::Mat R;
  cv::Rodrigues(rotation, R);
  SE3 T;
  cv::cv2eigen(R, T.R);
  for (int i = 0; i < 3; ++i) T.t(i) = translation.at<double>(i);
  return T;
}

double rms(double squared_error, std::size_t corners) {
  return std::sqrt(squared_error / static_cast<double>(corners));
}

// The pose of one view of a camera that is about right: the rays through the corners, on a plane in front of it.
std::optional<SE3> first_pose(const Board& board, const Camera& camera, const BoardCorners& corners) {
  std::vector<cv::Point2d> seen;
  std::vector<cv::Point3d> points;
  for (int i = 0; i < board.corners(); ++i) {
    const auto ray = unproject(camera, corners[static_cast<std::size_t>(i)]);
    constexpr double kSideways = 0.1;  // cosine
    if (!ray || ray->z() < kSideways) continue;
    seen.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
    points.emplace_back(board.point(i).x(), board.point(i).y(), 0);
  }
  if (seen.size() < 6) return std::nullopt;
  cv::Mat rotation, translation;
  try {
    if (!cv::solvePnP(points, seen, cv::Matx33d::eye(), cv::noArray(), rotation, translation, false, cv::SOLVEPNP_IPPE))
      return std::nullopt;
  } catch (const cv::Exception&) {  // corners that are no picture of a plane
    return std::nullopt;
  }
  const SE3 T = pose_of(rotation, translation);
  if (!T.R.allFinite() || !T.t.allFinite()) return std::nullopt;
  return T;
}

Solution refined(const Board& board, Solution start) {
  start.bundle = refine_calibration(board, start.camera, start.views);
  return start;
}

Solution solve_pinhole(std::span<const BoardCorners* const> views, const Board& board, int width, int height) {
  const std::vector<std::vector<cv::Point3f>> points(views.size(), points_of(board));
  std::vector<std::vector<cv::Point2f>> corners;
  for (const BoardCorners* view : views) {
    corners.emplace_back();
    for (const Eigen::Vector2d& p : *view)
      corners.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  cv::Mat K, D;
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::calibrateCamera(points, corners, {width, height}, K, D, rotations, translations, 0);
  } catch (const cv::Exception&) {
    throw std::runtime_error("these views do not determine the camera" + std::string(kMoreViews));
  }
  Solution start;
  start.camera = {.width = width, .height = height, .lens = Lens::radial_tangential};
  start.camera.fx = K.at<double>(0, 0), start.camera.fy = K.at<double>(1, 1);
  start.camera.cx = K.at<double>(0, 2), start.camera.cy = K.at<double>(1, 2);
  for (int i = 0; i < 5; ++i) start.camera.distortion[static_cast<std::size_t>(i)] = D.at<double>(i);
  for (std::size_t v = 0; v < views.size(); ++v)
    start.views.push_back({views[v], pose_of(rotations[v], translations[v])});
  return refined(board, std::move(start));
}

// A fisheye's image plane is nearly its angles, so the first guess has no distortion, and its focal length is that of
// a few fields of view which fits best.
Solution solve_fisheye(std::span<const BoardCorners* const> views, const Board& board, int width, int height) {
  Solution best;
  for (const double diagonal_deg : {60., 90., 120., 150., 180., 220.}) {
    Solution start;
    start.camera = {.width = width, .height = height, .lens = Lens::equidistant};
    start.camera.fx = start.camera.fy = std::hypot(width, height) / (diagonal_deg * M_PI / 180);
    start.camera.cx = 0.5 * (width - 1), start.camera.cy = 0.5 * (height - 1);
    for (const BoardCorners* view : views)
      if (const std::optional<SE3> T = first_pose(board, start.camera, *view)) {
        start.views.push_back({view, *T});
        refine_pose(board, start.camera, start.views.back());
      }
    if (start.views.size() < views.size()) continue;
    Solution solution = refined(board, std::move(start));
    if (solution.bundle.squared_error < best.bundle.squared_error) best = std::move(solution);
  }
  if (best.views.empty())
    throw std::runtime_error("these views do not determine the fisheye" + std::string(kMoreViews));
  return best;
}

Solution solve(std::span<const BoardCorners* const> views, const Board& board, int width, int height, Lens lens) {
  return lens == Lens::equidistant ? solve_fisheye(views, board, width, height)
                                   : solve_pinhole(views, board, width, height);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The view that fits worst, where it is out of proportion.
std::optional<std::size_t> worst_view(const Board& board, const Solution& solution) {
  constexpr double kOutOfProportion = 3;
  std::vector<double> errors;
  for (const BoardView& view : solution.views)
    errors.push_back(rms(squared_error(board, solution.camera, view), view.corners->size()));
  const auto worst = std::max_element(errors.begin(), errors.end());
  if (*worst <= kOutOfProportion * median(errors)) return std::nullopt;
  return static_cast<std::size_t>(worst - errors.begin());
}

// Calibrated without one part of the views after the other: what is left in the views of that part.
double kept_out_rms(const Board& board, const Solution& all) {
  constexpr std::size_t kParts = 4;
  double sum = 0;
  std::size_t corners = 0;
  for (std::size_t part = 0; part < std::min(kParts, all.views.size()); ++part) {
    Camera camera = all.camera;
    std::vector<BoardView> rest;
    for (std::size_t v = 0; v < all.views.size(); ++v)
      if (v % kParts != part) rest.push_back(all.views[v]);
    if (rest.size() < kFewestViews) return std::numeric_limits<double>::quiet_NaN();
    refine_calibration(board, camera, rest);
    for (std::size_t v = part; v < all.views.size(); v += kParts) {
      BoardView view = all.views[v];
      sum += refine_pose(board, camera, view);
      corners += view.corners->size();
    }
  }
  return rms(sum, corners);
}

// Distances of points from the line through them that fits best.
void add_distances(const std::vector<Eigen::Vector2d>& line, std::vector<double>& distances) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : line) centre += p / static_cast<double>(line.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : line) scatter += (p - centre) * (p - centre).transpose();
  const Eigen::Vector2d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(0);
  for (const Eigen::Vector2d& p : line) distances.push_back(std::abs(normal.dot(p - centre)));
}

double straightness(const Board& board, const Solution& solution) {
  const Camera& c = solution.camera;
  std::vector<double> distances;
  for (const BoardView& view : solution.views) {
    const auto straight = [&](int i) -> std::optional<Eigen::Vector2d> {
      const auto ray = unproject(c, (*view.corners)[static_cast<std::size_t>(i)]);
      if (!ray || ray->z() < 0.1) return std::nullopt;
      return Eigen::Vector2d(c.fx * ray->x() / ray->z() + c.cx, c.fy * ray->y() / ray->z() + c.cy);
    };
    const auto add_line = [&](int first, int step, int count) {
      std::vector<Eigen::Vector2d> line;
      for (int i = 0; i < count; ++i)
        if (const auto p = straight(first + i * step)) line.push_back(*p);
      if (line.size() > 2) add_distances(line, distances);
    };
    for (int row = 0; row < board.rows; ++row) add_line(row * board.columns, 1, board.columns);
    for (int column = 0; column < board.columns; ++column) add_line(column, board.columns, board.rows);
  }
  return distances.empty() ? std::numeric_limits<double>::quiet_NaN() : median(distances);
}

void check_determined(const Solution& s) {
  const Camera& c = s.camera;
  const bool sane = std::isfinite(s.bundle.squared_error) && c.fx > 0 && c.fy > 0 && s.bundle.covariance.size() > 0 &&
                    std::sqrt(s.bundle.covariance(0, 0)) < 0.25 * c.fx && std::abs(c.cx) < 10 * c.width &&
                    std::abs(c.cy) < 10 * c.height;
  if (!sane) throw std::runtime_error("these views do not determine the camera" + std::string(kMoreViews));
}

}  // namespace

CalibrationResult calibrate_camera(std::span<const BoardCorners> views, const Board& board, int width, int height,
                                   Lens lens) {
  if (views.size() < kFewestViews)
    throw std::runtime_error("the board was found in " + std::to_string(views.size()) + " pictures; expected " +
                             std::to_string(kFewestViews) + " or more" + kMoreViews);
  std::vector<const BoardCorners*> used;
  for (const BoardCorners& view : views) used.push_back(&view);
  Solution solution = solve(used, board, width, height, lens);
  while (2 * (used.size() - 1) >= views.size() && used.size() > kFewestViews) {
    const std::optional<std::size_t> worst = worst_view(board, solution);
    if (!worst) break;
    used.erase(used.begin() + static_cast<std::ptrdiff_t>(*worst));
    solution = solve(used, board, width, height, lens);
  }
  check_determined(solution);

  CalibrationResult result;
  result.camera = solution.camera;
  result.used = static_cast<int>(used.size());
  result.sigma = {.width = width, .height = height, .lens = lens};
  for (int i = 0; i < parameter_count(lens); ++i)
    parameter(result.sigma, i) = std::sqrt(solution.bundle.covariance(i, i));
  const auto corners = static_cast<std::size_t>(board.corners());
  result.rms_px = rms(solution.bundle.squared_error, corners * used.size());
  result.kept_out_rms_px = kept_out_rms(board, solution);
  result.straightness_px = straightness(board, solution);
  for (const BoardCorners& corners_of_view : views) {
    const auto at = std::find(used.begin(), used.end(), &corners_of_view);
    CalibratedView view{.used = at != used.end()};
    BoardView one{&corners_of_view, {}};
    if (view.used) {
      one = solution.views[static_cast<std::size_t>(at - used.begin())];
      view.rms_px = rms(squared_error(board, solution.camera, one), corners);
    } else {
      const std::optional<SE3> T = first_pose(board, solution.camera, corners_of_view);
      one.T_c_b = T.value_or(SE3{});
      view.rms_px = T ? rms(refine_pose(board, solution.camera, one), corners) : kInfinite;
    }
    view.T_c_b = one.T_c_b;
    result.views.push_back(view);
  }
  return result;
}

}  // namespace pavo
