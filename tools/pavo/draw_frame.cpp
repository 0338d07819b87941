#include "tools/pavo/draw_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>

namespace pavo {
namespace {

// BGR
const cv::Scalar kKeypoint(170, 170, 170), kInlier(80, 200, 60), kOutlier(50, 50, 170), kDropped(0, 140, 255),
    kPerson(0, 220, 255), kPath(208, 95, 31), kInk(255, 255, 255), kPanel(32, 32, 32);

cv::Point2f at(float x, float y) {
  return {x, y};
}

cv::Rect2f rectangle(const PersonBox& box) {
  return {box.x, box.y, box.width, box.height};
}

cv::Mat canvas_of(const Image& image) {
  if (image.empty()) return cv::Mat(370, 1226, CV_8UC3, kPanel);
  cv::Mat gray(image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
               static_cast<std::size_t>(image.stride()));
  cv::Mat canvas;
  cv::cvtColor(gray, canvas, cv::COLOR_GRAY2BGR);
  return canvas;
}

void draw_features(cv::Mat& canvas, const FrameSnapshot& s) {
  for (std::size_t i = 0; i < s.keypoints.size(); ++i) {
    const bool dropped = i < s.pose.kept.size() && !s.pose.kept[i];
    cv::circle(canvas, at(s.keypoints[i].x, s.keypoints[i].y), dropped ? 3 : 2, dropped ? kDropped : kKeypoint, 1,
               cv::LINE_AA);
  }
  for (const bool inliers : {false, true})  // the inliers on top
    for (std::size_t i = 0; i < s.pose.pairs.size(); ++i) {
      const bool inlier = i < s.pose.is_inlier.size() && s.pose.is_inlier[i];
      if (inlier != inliers) continue;
      const PointPair& p = s.pose.pairs[i];
      cv::line(canvas, at(p.x_previous, p.y_previous), at(p.x_current, p.y_current), inlier ? kInlier : kOutlier, 1,
               cv::LINE_AA);
    }
}

void draw_people(cv::Mat& canvas, const FrameSnapshot& s) {
  for (const PersonBox& box : s.detections) cv::rectangle(canvas, rectangle(box), kPerson, 1, cv::LINE_AA);
  for (const PersonBox& box : s.people) cv::rectangle(canvas, rectangle(box), kPerson, 2, cv::LINE_AA);
}

void draw_caption(cv::Mat& canvas, const FrameSnapshot& s) {
  const PoseResult& p = s.pose;
  const std::string text = fmt::format("{} {}  {}{}  keypoints {}  on people {}  matches {}  inliers {}", s.index,
                                       s.name, s.failed ? "FAILED, " : "", name_of(p.quality), p.keypoints,
                                       p.dropped_on_people, p.matches, p.inliers);
  cv::rectangle(canvas, cv::Rect(0, canvas.rows - 20, canvas.cols, 20), kPanel, cv::FILLED);
  cv::putText(canvas, text, {6, canvas.rows - 6}, cv::FONT_HERSHEY_SIMPLEX, 0.45, kInk, 1, cv::LINE_AA);
}

// The path from above, x right, z up, scaled to the inset.
void draw_path(cv::Mat& canvas, const std::vector<Eigen::Vector3d>& path) {
  const int side = std::min(canvas.rows / 3, canvas.cols / 5);
  if (path.empty() || side < 40) return;
  const cv::Rect inset(canvas.cols - side - 6, 6, side, side);
  canvas(inset) *= 0.25;
  Eigen::Vector3d low = path.front(), high = path.front();
  for (const Eigen::Vector3d& p : path) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double span = std::max({high.x() - low.x(), high.z() - low.z(), 1e-9});
  const double scale = (side - 16) / span;
  std::vector<cv::Point> line;
  for (const Eigen::Vector3d& p : path)
    line.emplace_back(inset.x + 8 + static_cast<int>((p.x() - low.x()) * scale),
                      inset.y + side - 8 - static_cast<int>((p.z() - low.z()) * scale));
  cv::polylines(canvas, line, false, kPath, 2, cv::LINE_AA);
  cv::circle(canvas, line.back(), 4, kInk, cv::FILLED, cv::LINE_AA);
}

}  // namespace

void take_snapshot(const Frame& frame, std::int64_t index, bool failed, FrameSnapshot& snapshot) {
  snapshot.index = index;
  snapshot.name = frame.name;
  snapshot.failed = failed;
  if (failed) {
    snapshot.image = Image();
    snapshot.keypoints.clear();
    snapshot.detections.clear();
    snapshot.people.clear();
    snapshot.pose = PoseResult{.T_w_c = frame.pose.T_w_c, .quality = frame.pose.quality};
    return;
  }
  snapshot.image.resize(frame.image.width(), frame.image.height());
  for (int y = 0; y < frame.image.height(); ++y)
    std::memcpy(snapshot.image.row(y), frame.image.row(y), static_cast<std::size_t>(frame.image.width()));
  snapshot.keypoints = frame.features.keypoints;
  snapshot.detections = frame.detections;
  snapshot.people = frame.people;
  snapshot.pose = frame.pose;
}

cv::Mat draw_frame(const FrameSnapshot& snapshot, const std::vector<Eigen::Vector3d>& path) {
  cv::Mat canvas = canvas_of(snapshot.image);
  draw_features(canvas, snapshot);
  draw_people(canvas, snapshot);
  draw_caption(canvas, snapshot);
  draw_path(canvas, path);
  return canvas;
}

}  // namespace pavo
