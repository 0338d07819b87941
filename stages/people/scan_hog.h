// The stage `scan`, our own: HOG and a linear classifier at every cell of every level of the pyramid, in SIMD.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stages/people/hog_rows.h"
#include "stages/people/people.h"
#include "stages/people/pyramid.h"
#include "stages/people/standing_prior.h"
#include "stages/people/window_scores.h"
#include "types/image.h"
#include "types/pedestrian_model.h"
#include "types/spread.h"

namespace pavo {

/// Which sizes of people are looked for. In a film it is enough to look for half of them in each frame, in turn: who is
/// between two sizes scores nearly as well at the next one, and is kept by the tracker until their own comes round.
enum class ScanLevels { all, even, odd };

struct ScanHogOptions {
  double scale_step = 1.05;  ///< from one pyramid level to the next, > 1
  int border_cells = 3;      ///< windows may reach so many cells beyond the image, which goes on with its edge pixels:
                         ///< people at the edges, the feet at the lower one above all, need it. OpenCV's default is 0
  float threshold = -1;                   ///< smallest probability that is reported; negative: the model's own
  float largest_share = 0.65f;            ///< of the smaller box, before the weaker one of two is dropped
  std::optional<StandingPrior> standing;  ///< only windows of people who stand on it are scanned
  Spread* spread = nullptr;               ///< who helps with the levels; null: nobody. Must outlive the stage
};

/// All windows of 64x128 px that lie within the image and its border, at every cell (8 px) of every level; with a
/// ground only the rows of them that can hold a person who stands on it: the same windows with the same scores, fewer
/// of them. Scores are probabilities.
///
/// May be called by any number of threads, each with its own Scratch; several may share the helpers. Allocates only
/// when an image is of another size than the one before, or has more candidates. The result does not depend on how many
/// threads there are: each level has its own list, and they are joined in order.
class ScanPeopleHog {
 public:
  struct Scratch {
    struct Chunk {  // what one hand needs for the level that it is at
      hog::HogRows rows;
      hog::WindowScores scores;
    };
    hog::Pyramid pyramid;
    std::vector<Chunk> chunks;
    std::vector<Detections> found;  // by level
    int width = 0, height = 0;      // of the image that all this was made for
  };

  /// Throws std::invalid_argument on a model or options out of range.
  explicit ScanPeopleHog(const PedestrianModel& model, const ScanHogOptions& options = {});

  /// The boxes of the persons in `image`, best first; none if the image is smaller than a window.
  void operator()(const Image& image, Detections& detections, Scratch& scratch) const {
    (*this)(image, options_.standing, ScanLevels::all, detections, scratch);
  }
  /// The same with another ground than the options', at some of the levels. Throws std::invalid_argument if the ground
  /// is out of its range.
  void operator()(const Image& image, const std::optional<StandingPrior>& standing, ScanLevels which,
                  Detections& detections, Scratch& scratch) const;

  /// The ground that is looked at unless another one is given.
  const std::optional<StandingPrior>& standing() const { return options_.standing; }

 private:
  void prepare(const Image& image, Scratch& scratch) const;
  void scan_level(const hog::Pyramid& pyramid, const hog::Level& level, const std::optional<StandingPrior>& standing,
                  Scratch::Chunk& chunk, Detections& found) const;

  PedestrianModel model_;
  ScanHogOptions options_;
  hog::DenseWeights weights_;
  float margin_;  // the threshold
};

}  // namespace pavo
