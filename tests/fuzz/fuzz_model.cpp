#include <cmath>
#include <string>

#include "drivers/models/model_file.h"
#include "tests/fuzz/fuzz.h"

/// A model has more numbers than a fuzzer would ever write. So the first byte says how many lines of 36 stand behind
/// the text, and the second how it ends.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pavo;
  if (size < 2) return 0;
  std::string text(reinterpret_cast<const char*>(data + 2), size - 2);
  for (int line = 0; line < data[0] % 107; ++line) {
    for (int k = 0; k < 36; ++k) text += "-1.5e-3 ";
    text += '\n';
  }
  if (data[1] & 1) text += "0.5\n";
  if (data[1] & 2) text += "end\n";
  fuzz::try_parse([&] { return parse_pedestrian_model(text, fuzz::kName); },
                  [](const PedestrianModel& model) {
                    const auto& f = model.features;
                    fuzz::require(model.weights.size() == PedestrianModel::kWeights, "a window's weights are whole");
                    for (const float w : model.weights) fuzz::require(std::isfinite(w), "weights are finite");
                    fuzz::require(f.epsilon > 0 && f.clip > 0 && f.fade > 0, "the features' parameters are positive");
                    fuzz::require(model.slope > 0 && std::isfinite(model.offset), "the calibration rises");
                    fuzz::require(model.threshold >= 0 && model.threshold <= 1, "the threshold is a probability");
                    const std::string written = pedestrian_model_text(model);
                    fuzz::require(pedestrian_model_text(parse_pedestrian_model(written, fuzz::kName)) == written,
                                  "what was written is read back");
                  });
  return 0;
}
