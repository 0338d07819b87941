#include "tools/pavo/train_state.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <iterator>
#include <locale>
#include <sstream>
#include <stdexcept>

#include "drivers/trajectories/append_file.h"

namespace pavo {
namespace {

constexpr const char* kMagic = "pavo-training 1";

}  // namespace

void write_train_state(const std::string& file, const TrainState& state, const std::string& fingerprint) {
  std::string text = fmt::format("{}\n{}\n{} {} {} {}\n", kMagic, fingerprint, state.round, state.complete ? 1 : 0,
                                 state.weights.size(), state.negatives.size());
  auto out = std::back_inserter(text);
  for (const double w : state.weights) fmt::format_to(out, "{}\n", w);
  for (const WindowPlace& p : state.negatives) fmt::format_to(out, "{} {} {} {}\n", p.image, p.level, p.x, p.y);
  text += "end\n";
  write_whole_file(file, text);
}

std::optional<TrainState> read_train_state(const std::string& file, const std::string& fingerprint) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  std::istringstream in(read_whole_file(file));
  in.imbue(std::locale::classic());
  std::string magic, training, end;
  std::getline(in, magic);
  std::getline(in, training);
  const std::string advice = "; remove it to begin anew";
  if (magic != kMagic) throw std::runtime_error(file + ": is no interrupted training of this pavo" + advice);
  if (training != fingerprint)
    throw std::runtime_error(file + ": belongs to a training with other pictures or options" + advice);
  TrainState state;
  std::size_t weights = 0, negatives = 0;
  in >> state.round >> state.complete >> weights >> negatives;
  if (in && weights < 100000 && negatives < 100000000) {
    state.weights.resize(weights);
    state.negatives.resize(negatives);
    for (double& w : state.weights) in >> w;
    for (WindowPlace& p : state.negatives) in >> p.image >> p.level >> p.x >> p.y;
  }
  if (!(in >> end) || end != "end" || weights != PedestrianModel::kWeights + 1 || state.round < 0)
    throw std::runtime_error(file + ": is not whole" + advice);
  for (const double w : state.weights)
    if (!std::isfinite(w)) throw std::runtime_error(file + ": holds a weight that is not finite" + advice);
  return state;
}

}  // namespace pavo
