// Training of the pedestrian classifier: a linear support vector machine on HOG, with mining of hard examples.
#pragma once

#include <oneapi/tbb/task_arena.h>
#include <compare>
#include <cstdint>
#include <functional>
#include <vector>

#include "types/image.h"
#include "types/pedestrian_model.h"

namespace pavo {

struct TrainOptions {
  HogOptions features;
  double C = 0.01;              ///< cost of a sample on the wrong side, against the width of the margin
  double positive_weight = 10;  ///< times C for positives
  double tolerance = 0.01;      ///< of the solver
  int shifts_px = 0;  ///< each positive also moved by so much to four sides (0: not), because windows are 8 px apart
  int random_negatives = 12000;  ///< over all images, evenly
  double hard_margin = 0;        ///< windows of negatives that score above are hard examples: false alarms
  int hard_per_image = 50;       ///< the hardest so many of one image and round
  int hard_total = 0;            ///< ... and of all images in one round; 0: no limit
  double easy_margin =
      -1.3;  ///< samples below leave the cache after a round; if they become hard again, they are found again
  int max_rounds = 12;           ///< of mining
  double done_per_image = 0.02;  ///< a round that finds fewer new false alarms (margin above 0) per image is the last
  int border_cells = 3;          ///< windows of negatives may reach so far beyond the image: as the scan's do
  double scale_step = 1.05;      ///< of the pyramid
  double false_alarms_per_image = 0.05;  ///< on the held-out negatives: sets the default threshold
  std::uint64_t seed = 1;
};

/// A window of a negative image, by level and cell.
struct WindowPlace {
  int image = 0, level = 0, x = 0, y = 0;
  auto operator<=>(const WindowPlace&) const = default;
};

/// Where a training stands between two rounds: enough to go on later.
struct TrainState {
  int round = 0;                       ///< rounds of mining that are done
  bool complete = false;               ///< the last round found nearly nothing
  std::vector<WindowPlace> negatives;  ///< that are in the cache
  std::vector<double> weights;         ///< and, last, the bias
};

/// The pictures, by number. A loader returns false for a picture that cannot be used: it is skipped. Loaders are called
/// by the arena's threads, several at once, with pictures in any order.
struct TrainData {
  int positives = 0, negatives = 0;
  std::function<bool(int, Image&)> load_positive;  ///< a person in the middle of at least 64x128 px, 96 to 100 px high
  std::function<bool(int, Image&)> load_negative;  ///< any size, without people
};

struct TrainProgress {
  const char* step;  ///< "positives", "negatives", "fit", "mining"
  int round;
  int done, total;
};

/// What a finished round has to tell.
struct RoundReport {
  int round = 0;                             ///< 0: random negatives only
  std::size_t positives = 0, negatives = 0;  ///< samples fitted
  std::size_t new_hard = 0;                  ///< windows above hard_margin that were not known
  std::size_t new_false = 0;                 ///< of these, above 0
  std::size_t windows = 0;                   ///< that were looked at
};

struct TrainCallbacks {
  std::function<bool(const TrainProgress&)> progress;  ///< false: stop now; the last state is where to go on
  std::function<void(const TrainState&, const RoundReport&)> round;  ///< after every fit
};

/// Fits on positives (and their mirror images) and random negatives; then scans all negative images densely, adds the
/// hard examples, fits again, until a round finds nearly none. `state` is empty, or where an earlier call stopped: the
/// result is the same. Repeatable: the same data, options and seed give the same weights for any number of threads.
/// Returns false if progress() said stop. Throws std::runtime_error if no positive, or no negative window, could be
/// used.
bool train_pedestrians(const TrainData& data, const TrainOptions& options, tbb::task_arena& arena,
                       const TrainCallbacks& callbacks, TrainState& state);

/// A model, and how it does on the pictures that were kept out.
struct Calibrated {
  PedestrianModel model;
  double false_alarms_per_image = 0;  ///< at the model's threshold
  double found = 0;                   ///< share of the positives that reach it
  double log_average_miss_rate = 1;   ///< over 9 rates of false alarms from 0.01 to 1 an image, after Dollar et al.
};

/// Fits the probability and the default threshold to pictures that were kept out of the training:
/// - positives: the margins of each person's window, moved by up to 3 px to all sides, as the scan's windows are;
/// - negatives: the margins of all boxes that the whole scan reports above a margin of -1, after suppression.
/// The probability is for pictures with one person in each on average: the positives weigh as much as there are
/// negative pictures. The threshold is the smallest at which there are at most false_alarms_per_image. Throws
/// std::runtime_error if no picture of one kind could be used, or the classifier tells nothing apart.
Calibrated calibrate_pedestrians(const TrainData& held_out, const TrainOptions& options, tbb::task_arena& arena,
                                 const std::vector<double>& weights_and_bias);

}  // namespace pavo
