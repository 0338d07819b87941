// calibrate_pedestrians() of train.h.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "stages/people/batches.h"
#include "stages/people/calibrate.h"
#include "stages/people/describe.h"
#include "stages/people/scan_hog.h"
#include "stages/people/train.h"

namespace pavo {
namespace {

constexpr double kLowestMargin = -1;  // of the boxes that count as negatives

bool always(int) {
  return true;
}

std::vector<double> margins_of_people(const TrainData& data, const PedestrianModel& model, tbb::task_arena& arena) {
  const auto margins_of = [&](int i) {
    std::vector<double> margins;
    Image crop;
    if (!data.load_positive(i, crop)) return margins;
    std::vector<float> descriptor(hog::kDescriptorSize);
    hog::CropDescriber describe(model.features);
    for (const int dx : {-3, 0, 3})
      for (const int dy : {-3, 0, 3}) {
        describe(crop, dx, dy, false, descriptor);
        double sum = static_cast<double>(model.bias);
        for (std::size_t k = 0; k < descriptor.size(); ++k)
          sum += static_cast<double>(descriptor[k]) * static_cast<double>(model.weights[k]);
        margins.push_back(sum);
      }
    return margins;
  };
  std::vector<double> all;
  in_batches<std::vector<double>>(data.positives, arena, always, margins_of, [&](int, const std::vector<double>& m) {
    all.insert(all.end(), m.begin(), m.end());
  });
  return all;
}

struct FalseAlarms {
  std::vector<double> margins;  // falling
  int pictures = 0;
};

/// `model` has the calibration 1:1.
FalseAlarms false_alarms(const TrainData& data, const TrainOptions& options, const PedestrianModel& model,
                         tbb::task_arena& arena) {
  const ScanPeopleHog scan(model, {.scale_step = options.scale_step,
                                   .border_cells = options.border_cells,
                                   .threshold = static_cast<float>(model.probability(kLowestMargin))});
  using Result = std::pair<bool, std::vector<double>>;
  const auto scan_picture = [&](int i) {
    Result result;
    Image image;
    result.first = data.load_negative(i, image);
    if (!result.first) return result;
    Detections found;
    ScanPeopleHog::Scratch scratch;
    scan(image, found, scratch);
    for (const PersonBox& b : found) result.second.push_back(model.margin(static_cast<double>(b.score)));
    return result;
  };
  FalseAlarms all;
  in_batches<Result>(data.negatives, arena, always, scan_picture, [&](int, const Result& result) {
    all.pictures += result.first;
    all.margins.insert(all.margins.end(), result.second.begin(), result.second.end());
  });
  std::sort(all.margins.begin(), all.margins.end(), std::greater<>());
  return all;
}

double share_above(const std::vector<double>& margins, double limit) {
  const auto above = std::count_if(margins.begin(), margins.end(), [&](double m) { return m >= limit; });
  return static_cast<double>(above) / static_cast<double>(margins.size());
}

double log_average_miss_rate(const std::vector<double>& people, const FalseAlarms& alarms, double lowest_margin) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) {
    const auto allowed = static_cast<std::size_t>(std::pow(10, -2 + k / 4.0) * alarms.pictures);
    const double limit = std::max(threshold_for(alarms.margins, allowed), lowest_margin);
    sum += std::log(std::max(1 - share_above(people, limit), 1e-10));
  }
  return std::exp(sum / 9);
}

}  // namespace

Calibrated calibrate_pedestrians(const TrainData& held_out, const TrainOptions& options, tbb::task_arena& arena,
                                 const std::vector<double>& weights_and_bias) {
  Calibrated result;
  PedestrianModel& model = result.model;
  model.features = options.features;
  model.weights.assign(weights_and_bias.begin(), weights_and_bias.end() - 1);
  model.bias = static_cast<float>(weights_and_bias.back());

  const std::vector<double> people = margins_of_people(held_out, model, arena);
  if (people.empty()) throw std::runtime_error("training: none of the positives that were kept out could be used");
  const FalseAlarms alarms = false_alarms(held_out, options, model, arena);
  if (alarms.pictures == 0)
    throw std::runtime_error("training: none of the negatives that were kept out could be used");

  const double margin = std::max(
      threshold_for(alarms.margins, static_cast<std::size_t>(options.false_alarms_per_image * alarms.pictures)),
      kLowestMargin);
  result.false_alarms_per_image =
      alarms.margins.empty()
          ? 0
          : share_above(alarms.margins, margin) * static_cast<double>(alarms.margins.size()) / alarms.pictures;
  result.found = share_above(people, margin);
  result.log_average_miss_rate = log_average_miss_rate(people, alarms, kLowestMargin);
  if (alarms.margins.empty()) {  // nothing to tell people from: too few pictures
    model.threshold = static_cast<float>(model.probability(margin));
    return result;
  }
  Sigmoid sigmoid;
  try {
    sigmoid = fit_sigmoid(people, alarms.margins, alarms.pictures / static_cast<double>(people.size()));
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(std::string("training: the classifier tells nothing apart on the pictures kept out (") +
                             e.what() + ")");
  }
  model.slope = sigmoid.slope;
  model.offset = sigmoid.offset;
  model.threshold = static_cast<float>(model.probability(margin));
  return result;
}

}  // namespace pavo
