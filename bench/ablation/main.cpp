// What does each part of the keyframe estimator buy? Runs it in a plain loop, with parts switched off.
//
//   bench_ablation SEQUENCE... [--people FOLDER] [--delay N] [KEY=VALUE...]
//
// Prints the path's errors, and the CPU time of the odometry (p50/p99) and of the map for a keyframe (p50), in
// cv::FAST(image, 20, true) on the same images, one thread ("F").
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "drivers/sequences/sequence.h"
#include "drivers/synthetic/synthetic_street.h"
#include "stages/decode/decode.h"
#include "stages/evaluation/evaluation.h"
#include "stages/features/extract.h"
#include "stages/keyframe/keyframe_odometry.h"
#include "stages/map/metric_map.h"
#include "stages/people/track_people.h"

namespace pavo::bench {
namespace {

double thread_cpu_ms() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

using Settings = std::map<std::string, double>;

double get(const Settings& s, const std::string& key, double fallback) {
  const auto it = s.find(key);
  return it == s.end() ? fallback : it->second;
}

std::vector<Detections> read_people(const std::filesystem::path& file) {
  std::vector<Detections> all;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::size_t frame;
    PersonBox box;
    words >> frame >> box.x >> box.y >> box.width >> box.height >> box.score;
    if (all.size() <= frame) all.resize(frame + 1);
    all[frame].push_back(box);
  }
  return all;
}

double percentile(std::vector<double> v, double share) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(share * static_cast<double>(v.size() - 1))];
}

cv::Mat as_mat(const Image& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
          static_cast<std::size_t>(image.stride())};
}

/// The unit of our times: OpenCV's FAST on the same image.
double opencv_fast_ms(const Image& image) {
  std::vector<cv::KeyPoint> corners;
  const double start = thread_cpu_ms();
  cv::FAST(as_mat(image), corners, 20, true);
  return thread_cpu_ms() - start;
}

/// What drives ahead at the same speed keeps its place in the picture, but for a little swaying: here the sequence's
/// own first picture, made `width` pixels wide, which has as many corners as a whole street.
class CarAhead {
 public:
  CarAhead(const Image& first, const Camera& camera, int width) : camera_(camera) {
    if (width > 0) cv::resize(as_mat(first), car_, {width, width * 4 / 5}, 0, 0, cv::INTER_AREA);
  }
  void drive_before(Image& image, std::size_t frame) const {
    if (car_.empty()) return;
    const auto t = static_cast<double>(frame);
    const cv::Rect place(static_cast<int>(camera_.cx - car_.cols / 2.0 + 6 * std::sin(t / 11)),
                         static_cast<int>(camera_.cy - car_.rows / 3.0 + 2 * std::sin(t / 3)), car_.cols, car_.rows);
    const cv::Rect seen = place & cv::Rect(0, 0, image.width(), image.height());
    car_(seen - place.tl()).copyTo(as_mat(image)(seen));
  }

 private:
  const Camera& camera_;
  cv::Mat car_;
};

struct Slot {
  Image image;
  Features features;
};

void run(const std::string& name, Sequence& sequence, const std::filesystem::path& people_file, const Settings& s) {
  const SequenceInfo& info = sequence.info();
  const Camera camera = *info.camera;
  std::vector<Detections> detections;
  if (!people_file.empty()) detections = read_people(people_file);
  TrackPeople track_people;
  KeyframeOdometryOptions options;
  options.max_points = static_cast<int>(get(s, "points", options.max_points));
  options.sigma_px = get(s, "sigma", options.sigma_px);
  options.loss_scale = get(s, "pose_loss", options.loss_scale);
  options.keyframe_px = get(s, "keyframe_px", options.keyframe_px);
  options.keyframe_share = get(s, "keyframe_share", options.keyframe_share);
  options.new_patch_ratio = get(s, "patch_ratio", options.new_patch_ratio);
  options.search_px = get(s, "search", options.search_px);
  options.least_spacing_px = static_cast<int>(get(s, "spacing", options.least_spacing_px));
  options.farthest_below = get(s, "below", options.farthest_below);
  options.max_coarse = static_cast<int>(get(s, "coarse", options.max_coarse));
  options.mature_px = get(s, "mature", options.mature_px);
  options.align.min_correlation = static_cast<float>(get(s, "ncc", options.align.min_correlation));
  MetricMapOptions metric;
  LocalMapOptions& map_options = metric.map;
  map_options.window = static_cast<int>(get(s, "window", map_options.window));
  map_options.fixed = static_cast<int>(get(s, "fixed", map_options.fixed));
  map_options.outlier_px = get(s, "outlier", map_options.outlier_px);
  metric.scale_walk = get(s, "scale_walk", metric.scale_walk);
  map_options.bundle.iterations = static_cast<int>(get(s, "iterations", map_options.bundle.iterations));
  map_options.bundle.loss_scale = get(s, "loss", map_options.bundle.loss_scale);
  map_options.refine_lens = get(s, "lens", 1) > 0;
  map_options.lens_sigma(0) = get(s, "lens_f", map_options.lens_sigma(0));
  map_options.lens_sigma(1) = get(s, "lens_k", map_options.lens_sigma(1));
  map_options.lens_least_sigma *= get(s, "lens_least", 1);
  const std::size_t delay = static_cast<std::size_t>(get(s, "delay", 2));
  const bool use_map = get(s, "map", 1) > 0;
  std::shared_ptr<const StepLength> scale = std::make_shared<UnitStep>();
  if (info.groundtruth && get(s, "unit", 0) == 0) scale = std::make_shared<GroundtruthStep>(*info.groundtruth);

  if (get(s, "height", 0) > 0) {
    metric.ground.emplace();
    metric.ground->filter.height_m = get(s, "height", 0);
    metric.ground->filter.attitude.pitch_rad = get(s, "pitch", 0);
    metric.ground->scale_walk = get(s, "gwalk", metric.ground->scale_walk);
    metric.ground->baseline = get(s, "gbase", metric.ground->baseline);
    metric.ground->filter.repetition = get(s, "grep", metric.ground->filter.repetition);
    metric.ground->filter.height_sigma = get(s, "gh", metric.ground->filter.height_sigma);
    metric.ground->filter.slope_sigma = get(s, "gs", metric.ground->filter.slope_sigma);
    metric.ground->filter.travel_sigma = get(s, "gtravel", metric.ground->filter.travel_sigma);
    metric.ground->filter.lever = get(s, "glever", metric.ground->filter.lever);
    scale = std::make_shared<UnknownStep>();
  }
  MetricMap map(camera, metric);
  KeyframeOdometry odometry(camera, options, scale);
  FeatureOptions feature_options;
  feature_options.max_features = 2000;
  const ExtractFeatures extract(feature_options, camera.width, camera.height);
  ExtractFeatures::Scratch scratch;
  const Decode decode(camera.width, camera.height);
  Decode::Scratch decode_scratch;
  Slot slots[2];
  EncodedImage encoded;
  FrameStamp stamp;
  std::deque<MapUpdate> updates;
  KeyframeRecord record;
  PoseResult pose;
  People people;
  Trajectory path;
  std::vector<double> fast_ms, odometry_ms, map_ms;
  int coasting = 0, standing = 0, keyframes = 0;
  std::size_t k = 0;
  const std::size_t most = static_cast<std::size_t>(get(s, "frames", 1e9));
  const int stride = static_cast<int>(get(s, "stride", 1));
  const std::size_t blank = static_cast<std::size_t>(get(s, "blank", 1e9)),
                    blanks = static_cast<std::size_t>(get(s, "blanks", 5));
  const std::size_t miss = static_cast<std::size_t>(get(s, "miss", 1e9)),
                    misses = static_cast<std::size_t>(get(s, "misses", 5));
  std::optional<CarAhead> car;
  Trajectory truth;
  std::vector<std::size_t> source_index;
  for (; k < most && sequence.read(encoded, stamp); ++k) {
    source_index.push_back(static_cast<std::size_t>(stamp.index));
    for (int skip = 1; skip < stride; ++skip) sequence.skip();
    Slot& now = slots[k % 2];
    const Slot& before = slots[(k + 1) % 2];
    decode(encoded, now.image, decode_scratch);
    if (k == 0) car.emplace(now.image, camera, static_cast<int>(get(s, "car", 0)));
    car->drive_before(now.image, k);
    if (k >= blank && k < blank + blanks)
      for (int y = 0; y < now.image.height(); ++y) std::fill_n(now.image.row(y), now.image.width(), std::uint8_t{128});
    extract(now.image, now.features, scratch);
    track_people(source_index[k] < detections.size() ? detections[source_index[k]] : Detections{}, people);
    if (people_file.empty()) people.clear();
    const MapUpdate* update = nullptr;
    MapUpdate taken;
    if (updates.size() >= delay && use_map) {
      taken = std::move(updates.front());
      updates.pop_front();
      update = &taken;
    }
    fast_ms.push_back(opencv_fast_ms(now.image));
    const FrameTime time{static_cast<std::int64_t>(source_index[k]), stamp.t_capture_ns, 0};
    const bool missed = k >= miss && k<miss + misses, missed_before = k> miss && k <= miss + misses;
    double start = thread_cpu_ms();
    const FrameView previous = k > 0 && !missed_before ? FrameView{&before.features, &before.image} : FrameView{};
    if (missed)
      odometry.missed(time, previous, update, pose, record);
    else
      odometry(time, {&now.features, &now.image}, previous, people, update, pose, record);
    odometry_ms.push_back(thread_cpu_ms() - start);
    start = thread_cpu_ms();
    updates.emplace_back();
    if (record.is_keyframe || (record.followed && map.needs_image())) map(record, now.image, people, updates.back());
    if (record.is_keyframe) map_ms.push_back(thread_cpu_ms() - start), ++keyframes;
    coasting += pose.quality == Quality::coasting || pose.quality == Quality::relocalising;
    standing += pose.quality == Quality::standing;
    path.T_w_c.push_back(pose.T_w_c);
  }
  if (const char* dump = std::getenv("KF_DUMP")) {
    std::ofstream out(dump);
    for (const SE3& T : path.T_w_c)
      for (int r = 0; r < 3; ++r)
        out << T.R(r, 0) << ' ' << T.R(r, 1) << ' ' << T.R(r, 2) << ' ' << T.t(r) << (r == 2 ? '\n' : ' ');
  }
  double length = 0;
  for (std::size_t i = 1; i < path.T_w_c.size(); ++i) length += (path.T_w_c[i].t - path.T_w_c[i - 1].t).norm();
  std::printf("%-22s", name.c_str());
  if (info.groundtruth && info.groundtruth->T_w_c.size() > source_index.back()) {
    for (const std::size_t i : source_index) truth.T_w_c.push_back(info.groundtruth->T_w_c[i]);
    EvaluationOptions how;
    how.step = name.find("05") != std::string::npos || name.find("crowd") != std::string::npos ? 10 : 1;
    const Evaluation e = evaluate(path, truth, how);
    const auto& all = e.raw.segments.all;
    std::printf(" ATE %6.3f scale %.3f", e.sim3.ate_m.rmse, e.sim3.similarity.scale);
    if (all) std::printf(" t_rel %6.2f r_rel %5.3f", all->t_rel_percent, all->r_rel_deg_per_100m);
    if (e.scaled && e.scaled->segments.all) std::printf(" scaled %6.2f", e.scaled->segments.all->t_rel_percent);
    std::printf(" rpe_t %.4f rpe_r %.4f", e.raw.rpe.translation_m.rmse, e.raw.rpe.rotation_deg.rmse);
  }
  std::printf(" lens %+.4f %+.4f", map.lens()(0), map.lens()(1));
  std::printf(" len %.2f coast %d stand %d kf %d", length, coasting, standing, keyframes);
  const double F = percentile(fast_ms, .5);
  std::printf(" | odo %.2f/%.2f F map %.2f F, F %.2f ms\n", percentile(odometry_ms, .5) / F,
              percentile(odometry_ms, .99) / F, percentile(map_ms, .5) / F, F);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  cv::setNumThreads(1);
  std::vector<std::string> sequences;
  Settings settings;
  std::filesystem::path people;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t equals = word.find('=');
    if (word == "--people")
      people = argv[++i];
    else if (equals != std::string::npos)
      settings[word.substr(0, equals)] = std::atof(word.c_str() + equals + 1);
    else
      sequences.push_back(word);
  }
  for (const std::string& name : sequences) {
    std::string base = std::filesystem::path(name).filename();
    std::filesystem::path file = people.empty() ? people : people / (base + ".csv");
    if (!file.empty() && !std::filesystem::exists(file)) file.clear();
    run(base, *open_sequence(name), file, settings);
  }
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc, argv);
}
