#include "stages/people/train.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <random>
#include <stdexcept>

#include "stages/people/batches.h"
#include "stages/people/describe.h"
#include "stages/people/linear_svm.h"
#include "stages/people/window_scores.h"

namespace pavo {
namespace {

struct Found {
  WindowPlace place;
  float margin;
  std::vector<float> descriptor;
};

/// One run of train_pedestrians().
class Training {
 public:
  Training(const TrainData& data, const TrainOptions& options, tbb::task_arena& arena, const TrainCallbacks& callbacks,
           TrainState& state)
      : data_(data),
        options_(options),
        arena_(arena),
        callbacks_(callbacks),
        state_(state),
        samples_(hog::kDescriptorSize) {}

  bool run() {
    if (!add_positives()) return false;
    if (state_.negatives.empty()) {
      if (!choose_random_negatives()) return false;
      if (!fit_and_report({})) return false;
    } else if (!describe_negatives(state_.negatives)) {
      return false;
    }
    while (!state_.complete && state_.round < options_.max_rounds) {
      RoundReport report;
      if (!mine(report)) return false;
      ++state_.round;
      state_.complete = static_cast<double>(report.new_false) < options_.done_per_image * data_.negatives;
      if (!fit_and_report(report)) return false;
    }
    return true;
  }

 private:
  using Descriptors = std::vector<std::vector<float>>;

  bool progress(const char* step, int done, int total) const {
    return !callbacks_.progress || callbacks_.progress({step, state_.round, done, total});
  }

  bool add_positives() {
    const int s = options_.shifts_px;
    const auto describe = [&](int i) {
      Descriptors out;
      Image crop;
      if (!data_.load_positive(i, crop)) return out;
      hog::CropDescriber describer(options_.features);
      for (auto [dx, dy] : {std::pair(0, 0), {-s, 0}, {s, 0}, {0, -s}, {0, s}})
        for (const bool mirrored : {false, true})
          if (s != 0 || out.size() < 2) describer(crop, dx, dy, mirrored, out.emplace_back(hog::kDescriptorSize));
      return out;
    };
    const bool all = in_batches<Descriptors>(
        data_.positives, arena_, [&](int n) { return progress("positives", n, data_.positives); }, describe,
        [&](int, const Descriptors& descriptors) {
          for (const auto& d : descriptors) samples_.add(d, true);
        });
    if (all && samples_.size() == 0) throw std::runtime_error("training: no positive picture could be used");
    positives_ = samples_.size();
    return all;
  }

  void plan(hog::Pyramid& pyramid, const Image& image) const {
    pyramid.plan(image.width(), image.height(), options_.scale_step, options_.features.tone,
                 hog::Sampling::as_soft_as_training, options_.border_cells * hog::kCell);
  }

  hog::Pyramid pyramid_of(const Image& image) const {
    hog::Pyramid pyramid;
    plan(pyramid, image);
    pyramid.load(image.view());
    return pyramid;
  }

  /// The same number of every image, at places that depend on the seed and the image alone.
  bool choose_random_negatives() {
    const int per_image = (options_.random_negatives + data_.negatives - 1) / std::max(1, data_.negatives);
    const auto choose = [&](int i) {
      std::vector<WindowPlace> places;
      Image image;
      if (!data_.load_negative(i, image)) return places;
      hog::Pyramid pyramid;
      plan(pyramid, image);
      std::mt19937_64 random(options_.seed * 1000003 + static_cast<std::uint64_t>(i));
      const auto below = [&](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
      const auto& levels = pyramid.levels();
      for (int k = 0; k < per_image && !levels.empty(); ++k) {
        const int level = below(static_cast<int>(levels.size()));
        const hog::Level& l = levels[static_cast<std::size_t>(level)];
        const int x = below(l.windows_x());
        places.push_back({i, level, x, below(l.windows_y())});
      }
      std::sort(places.begin(), places.end());
      places.erase(std::unique(places.begin(), places.end()), places.end());
      return places;
    };
    std::vector<WindowPlace> all;
    const bool done = in_batches<std::vector<WindowPlace>>(
        data_.negatives, arena_, [&](int n) { return progress("negatives", n, data_.negatives); }, choose,
        [&](int, const std::vector<WindowPlace>& places) { all.insert(all.end(), places.begin(), places.end()); });
    if (!done) return false;
    if (all.empty()) throw std::runtime_error("training: no negative picture could be used");
    return describe_negatives(all);
  }

  [[noreturn]] static void refuse_state() {
    throw std::runtime_error("training: the state names windows that the pictures do not have");
  }

  using Placed = std::vector<std::pair<std::size_t, WindowPlace>>;  // and where in the order of the samples

  /// Adds the windows at these places to the samples, in this order: the solver's sums depend on it, and a training
  /// that goes on shall give the same bits as one that was never stopped.
  bool describe_negatives(const std::vector<WindowPlace>& places) {
    std::map<int, Placed> of_image;
    for (std::size_t i = 0; i < places.size(); ++i) of_image[places[i].image].emplace_back(i, places[i]);
    if (!of_image.empty() && (of_image.begin()->first < 0 || of_image.rbegin()->first >= data_.negatives))
      refuse_state();
    std::vector<Placed> images;
    for (auto& [image, placed] : of_image) {
      std::sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
      images.push_back(std::move(placed));
    }
    std::vector<Found> found(places.size());
    const int n = static_cast<int>(images.size());
    const bool all = in_batches<std::vector<Found>>(
        n, arena_, [&](int k) { return progress("negatives", k, n); },
        [&](int k) { return describe_places(images[static_cast<std::size_t>(k)]); },
        [&](int k, std::vector<Found>& described) {
          const Placed& placed = images[static_cast<std::size_t>(k)];
          for (std::size_t i = 0; i < described.size(); ++i) found[placed[i].first] = std::move(described[i]);
        });
    if (!all) return false;
    state_.negatives.clear();
    std::erase_if(found, [](const Found& f) { return f.descriptor.empty(); });  // their picture could not be read
    add_negatives(found);
    return true;
  }

  /// Places of one image, sorted.
  std::vector<Found> describe_places(const Placed& placed) const {
    std::vector<Found> out;
    Image pixels;
    if (!data_.load_negative(placed[0].second.image, pixels)) return out;
    const hog::Pyramid pyramid = pyramid_of(pixels);
    hog::HogRows rows;
    hog::LevelBlocks blocks;
    int computed = -1;
    for (const auto& [i, p] : placed) {
      if (p.level < 0 || p.level >= static_cast<int>(pyramid.levels().size())) refuse_state();
      const hog::Level& level = pyramid.levels()[static_cast<std::size_t>(p.level)];
      if (p.x < 0 || p.x >= level.windows_x() || p.y < 0 || p.y >= level.windows_y()) refuse_state();
      if (p.level != computed) blocks.compute(pyramid, level, options_.features, rows);
      computed = p.level;
      Found& found = out.emplace_back(Found{p, 0.0f, std::vector<float>(hog::kDescriptorSize)});
      blocks.describe(p.x, p.y, found.descriptor);
    }
    return out;
  }

  void add_negatives(const std::vector<Found>& found) {
    for (const Found& f : found) {
      samples_.add(f.descriptor, false);
      state_.negatives.push_back(f.place);
    }
  }

  std::vector<Found> hard_examples(int image, const hog::DenseWeights& weights, const std::vector<WindowPlace>& known,
                                   std::size_t& windows) const {
    std::vector<Found> hard;
    Image pixels;
    windows = 0;
    if (!data_.load_negative(image, pixels)) return hard;
    const hog::Pyramid pyramid = pyramid_of(pixels);
    hog::HogRows rows;
    hog::LevelBlocks blocks;
    hog::WindowScores scores;
    for (std::size_t k = 0; k < pyramid.levels().size(); ++k) {
      const hog::Level& level = pyramid.levels()[k];
      blocks.compute(pyramid, level, options_.features, rows);
      scores.start(weights, level.windows_x(), level.windows_y());
      for (int row = 0; row < blocks.rows(); ++row) {
        scores.add(blocks.row(row), blocks.stride());
        const std::span<const float> line = scores.completed();
        windows += line.size();
        for (std::size_t x = 0; x < line.size(); ++x) {
          if (!(static_cast<double>(line[x]) > options_.hard_margin)) continue;
          const WindowPlace place{image, static_cast<int>(k), static_cast<int>(x), scores.completed_row()};
          if (std::binary_search(known.begin(), known.end(), place)) continue;
          Found& found = hard.emplace_back(Found{place, line[x], std::vector<float>(hog::kDescriptorSize)});
          blocks.describe(place.x, place.y, found.descriptor);
        }
      }
    }
    keep_hardest(hard, static_cast<std::size_t>(options_.hard_per_image));
    return hard;
  }

  bool mine(RoundReport& report) {
    const std::span<const double> w(state_.weights);
    const std::vector<float> floats(w.begin(), w.end() - 1);
    const hog::DenseWeights weights(floats, static_cast<float>(w.back()));
    std::vector<WindowPlace> known = state_.negatives;
    std::sort(known.begin(), known.end());
    std::vector<Found> hard;
    using Result = std::pair<std::vector<Found>, std::size_t>;
    const bool all = in_batches<Result>(
        data_.negatives, arena_, [&](int n) { return progress("mining", n, data_.negatives); },
        [&](int i) {
          Result result;
          result.first = hard_examples(i, weights, known, result.second);
          return result;
        },
        [&](int, Result& result) {
          report.windows += result.second;
          std::move(result.first.begin(), result.first.end(), std::back_inserter(hard));
          if (options_.hard_total == 0) take(hard, report);
        });
    if (options_.hard_total > 0) keep_hardest(hard, static_cast<std::size_t>(options_.hard_total));
    take(hard, report);
    return all;
  }

  static void keep_hardest(std::vector<Found>& hard, std::size_t n) {
    std::stable_sort(hard.begin(), hard.end(), [](const Found& a, const Found& b) { return a.margin > b.margin; });
    if (hard.size() > n) hard.resize(n);
  }

  void take(std::vector<Found>& hard, RoundReport& report) {
    add_negatives(hard);
    report.new_hard += hard.size();
    report.new_false +=
        static_cast<std::size_t>(std::count_if(hard.begin(), hard.end(), [](const Found& f) { return f.margin > 0; }));
    hard.clear();
  }

  bool fit_and_report(RoundReport report) {
    if (!progress("fit", 0, 1)) return false;
    state_.weights = fit_linear_svm(samples_, options_.C, options_.positive_weight, options_.tolerance, state_.weights);
    report.round = state_.round;
    report.positives = positives_;
    report.negatives = samples_.size() - positives_;
    forget_easy_negatives();
    if (callbacks_.round) callbacks_.round(state_, report);
    return progress("fit", 1, 1);
  }

  void forget_easy_negatives() {
    std::vector<char> keep(samples_.size(), 1);
    std::vector<WindowPlace> places;
    for (std::size_t i = positives_; i < samples_.size(); ++i) {
      keep[i] = samples_.margin(i, state_.weights) > options_.easy_margin;
      if (keep[i]) places.push_back(state_.negatives[i - positives_]);
    }
    samples_.keep_only(keep);
    state_.negatives = std::move(places);
  }

  const TrainData& data_;
  const TrainOptions& options_;
  tbb::task_arena& arena_;
  const TrainCallbacks& callbacks_;
  TrainState& state_;
  SvmSamples samples_;  // the positives, then state_.negatives in their order
  std::size_t positives_ = 0;
};

}  // namespace

bool train_pedestrians(const TrainData& data, const TrainOptions& options, tbb::task_arena& arena,
                       const TrainCallbacks& callbacks, TrainState& state) {
  return Training(data, options, arena, callbacks, state).run();
}

}  // namespace pavo
