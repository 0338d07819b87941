// The last keyframes and their points, adjusted together. Its unit of length is whatever it is told.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "stages/map/bundle_adjustment.h"
#include "stages/map/map_messages.h"

namespace pavo {

struct LocalMapOptions {
  int window = 10;        ///< keyframes that are kept, 3 to Bundle::kMaxFree
  int fixed = 2;          ///< of them, the oldest, that are not moved: they carry position, direction and scale
  double outlier_px = 3;  ///< a keyframe's observation that is farther off is dropped
  BundleOptions bundle;
  /// What the calibration may be off by, and how fast that may change: standard deviations of LensError.
  bool refine_lens = true;
  LensError lens_sigma{0.003, 0.01}, lens_least_sigma{3e-4, 3e-4};
};

/// In order, one caller at a time; never blocks; allocates only to grow.
class LocalMap {
 public:
  LocalMap(const Camera& camera, const LocalMapOptions& options);

  /// The next keyframe joins, and all are adjusted. Its lengths times `unit` are the map's. Where none is here that it
  /// hangs on, what was here is forgotten, and it is the first of a new map.
  void add(const KeyframeRecord& record, double unit = 1);
  /// Where the frame is in the newest keyframe's camera, in its own unit; nothing where it does not hang on that one.
  std::optional<SE3> in_newest(const KeyframeRecord& record) const;
  /// Whether the newest keyframe is the one that T_last_c is from.
  bool is_next(const KeyframeRecord& record) const;
  std::int64_t newest_frame() const { return window_[keyframe(count_ - 1)].frame; }
  const SE3& newest_pose() const { return window_[keyframe(count_ - 1)].T_w_c; }
  /// Of the way between the two newest keyframes; 0 where there is none.
  double newest_baseline() const;
  /// Lengths are so many times as large; the newest keyframe stays where it is.
  void rescale(double factor);
  /// What the odometry is to know, but for all that is about scale.
  void report(MapUpdate& update) const;

  const LensError& lens() const { return lens_; }
  const LocalMapOptions& options() const { return options_; }

 private:
  struct Observation {
    PointId point = 0;
    float x = 0, y = 0, inverse_sigma = 1;
  };
  struct Keyframe {
    std::int64_t frame = -1;
    SE3 T_w_c;
    std::vector<Observation> observations;
  };
  struct Point {
    PointId id = 0;  ///< 0: empty
    RayPoint ray;
    bool good = true;
    int count = 0, bundle = -1;
  };

  Point* find(PointId id);
  void reset();
  void insert(const KeyframeRecord& record, const std::optional<SE3>& in_newest, double unit);
  void build();
  void take_over();
  void cull();
  void learn_lens(const Eigen::Matrix2d& information);

  static constexpr std::size_t kTable = 8192;  ///< points by id; ids run on, so that old ones are overwritten

  Camera camera_;
  LocalMapOptions options_;
  BundleAdjustment adjust_;
  Bundle bundle_;
  std::vector<Keyframe> window_;  ///< ring: oldest at first_
  std::size_t first_ = 0, count_ = 0;
  std::vector<Point> points_;
  std::vector<PointId> order_;  ///< of the bundle's points
  std::vector<int> cursor_;
  LensError lens_ = LensError::Zero();
  Eigen::Matrix2d lens_information_ = Eigen::Matrix2d::Zero();
  std::size_t keyframe(std::size_t i) const { return (first_ + i) % window_.size(); }
};

}  // namespace pavo
