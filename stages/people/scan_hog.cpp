#include "stages/people/scan_hog.h"

#include <cmath>
#include <stdexcept>

#include "stages/people/person_window.h"
#include "stages/people/suppress.h"

namespace pavo {
namespace {

// Windows of one size that answer, before suppression. For more, memory is asked for while frames run.
constexpr std::size_t kUsual = 64;

const PedestrianModel& checked(const PedestrianModel& model) {
  const auto refuse = [](const char* what) { throw std::invalid_argument(std::string("scan: the model's ") + what); };
  if (model.weights.size() != PedestrianModel::kWeights) refuse("weights are not 3780");
  for (const float w : model.weights)
    if (!std::isfinite(w)) refuse("weights are not all finite");
  if (!std::isfinite(model.bias)) refuse("bias is not finite");
  if (!(model.slope > 0) || !std::isfinite(model.slope) || !std::isfinite(model.offset))
    refuse("calibration is not a rising curve");
  if (!(model.features.epsilon > 0) || !(model.features.clip > 0) || !(model.features.fade > 0))
    refuse("epsilon, clip and fade must be positive");
  return model;
}

}  // namespace

ScanPeopleHog::ScanPeopleHog(const PedestrianModel& model, const ScanHogOptions& options)
    : model_(checked(model)), options_(options), weights_(model.weights, model.bias) {
  if (!(options_.scale_step > 1)) throw std::invalid_argument("scan: scale_step must be larger than 1");
  if (options_.border_cells < 0 || options_.border_cells > 16)
    throw std::invalid_argument("scan: border_cells must be from 0 to 16");
  if (options_.standing) check(*options_.standing);
  if (options_.threshold > 1) throw std::invalid_argument("scan: threshold is a probability, at most 1");
  if (options_.threshold < 0) options_.threshold = model_.threshold;
  margin_ = static_cast<float>(model_.margin(static_cast<double>(options_.threshold)));
}

void ScanPeopleHog::operator()(const Image& image, const std::optional<StandingPrior>& standing, ScanLevels which,
                               Detections& detections, Scratch& scratch) const {
  if (standing) check(*standing);
  detections.clear();
  if (image.width() < hog::kWindowWidth || image.height() < hog::kWindowHeight) return;
  scratch.pyramid.plan(image.width(), image.height(), options_.scale_step, model_.features.tone,
                       hog::Sampling::as_soft_as_training, options_.border_cells * hog::kCell);
  const std::vector<hog::Level>& levels = scratch.pyramid.levels();
  scratch.pyramid.load(image.view());

  prepare(image, scratch);

  // The largest level comes first, and whoever is free takes the next.
  const std::size_t first = which == ScanLevels::odd ? 1 : 0, step = which == ScanLevels::all ? 1 : 2;
  const auto turn = [&](int hand, int k) {
    const std::size_t level = first + step * static_cast<std::size_t>(k);
    scan_level(scratch.pyramid, levels[level], standing, scratch.chunks[static_cast<std::size_t>(hand)],
               scratch.found[level]);
  };
  const std::size_t turns = (levels.size() - first + step - 1) / step;
  spread_or_not(options_.spread, static_cast<int>(turns), turn);

  detections.reserve(4 * kUsual);
  for (std::size_t k = first; k < levels.size(); k += step)
    detections.insert(detections.end(), scratch.found[k].begin(), scratch.found[k].end());
  suppress_non_maxima(detections, options_.largest_share);
}

// Memory for every hand, also for those that help for the first time only when all else is warm.
void ScanPeopleHog::prepare(const Image& image, Scratch& scratch) const {
  const std::vector<hog::Level>& levels = scratch.pyramid.levels();
  const auto hands = static_cast<std::size_t>(options_.spread ? options_.spread->hands() : 1);
  if (scratch.chunks.size() == hands && scratch.width == image.width() && scratch.height == image.height()) return;
  scratch.chunks.resize(hands);
  scratch.found.resize(levels.size());
  for (Detections& found : scratch.found) found.reserve(kUsual);
  for (Scratch::Chunk& chunk : scratch.chunks) {
    chunk.rows.start(scratch.pyramid, levels[0], model_.features);
    chunk.scores.start(weights_, levels[0].windows_x(), levels[0].windows_y());
  }
  scratch.width = image.width();
  scratch.height = image.height();
}

void ScanPeopleHog::scan_level(const hog::Pyramid& pyramid, const hog::Level& level,
                               const std::optional<StandingPrior>& standing, Scratch::Chunk& chunk,
                               Detections& found) const {
  found.clear();
  const WindowRows rows = standing ? rows_on_ground(*standing, level) : WindowRows{0, level.windows_y()};
  if (rows.begin >= rows.end) return;
  chunk.rows.start(pyramid, level, model_.features, rows.begin);
  chunk.scores.start(weights_, level.windows_x(), rows.end - rows.begin);
  const auto width = static_cast<float>(hog::kWindowWidth * level.step_x);
  const auto height = static_cast<float>(hog::kWindowHeight * level.step_y);
  for (int row = rows.begin; row < rows.end + hog::kBlocksY - 1 && chunk.rows.next(); ++row) {
    chunk.scores.add(chunk.rows.blocks(), chunk.rows.stride());
    const std::span<const float> scores = chunk.scores.completed();
    const auto y = static_cast<float>(level.image_y(rows.begin + chunk.scores.completed_row()));
    for (std::size_t x = 0; x < scores.size(); ++x)
      if (scores[x] >= margin_)
        found.push_back(person_in_window(static_cast<float>(level.image_x(static_cast<int>(x))), y, width, height,
                                         static_cast<float>(model_.probability(static_cast<double>(scores[x])))));
  }
}

}  // namespace pavo
