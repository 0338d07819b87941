#include "tools/pavo/train.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "drivers/models/model_file.h"
#include "drivers/trajectories/sha256.h"
#include "stages/people/symmetry.h"
#include "stages/people/train.h"
#include "tools/pavo/picture_files.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/signals.h"
#include "tools/pavo/train_state.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

struct TrainCall {
  std::string positives, negatives, out;
  int hold_out = 200;
  int workers = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  TrainOptions options;
};

/// A part of a folder. What cannot be used is told once, and skipped from then on.
class PictureSet {
 public:
  explicit PictureSet(std::vector<fs::path> files, int least_width = 1, int least_height = 1)
      : files_(std::move(files)), least_width_(least_width), least_height_(least_height) {}

  int size() const { return static_cast<int>(files_.size()); }
  const std::vector<fs::path>& files() const { return files_; }

  /// By any thread.
  bool load(int i, Image& image) {
    const fs::path& file = files_[static_cast<std::size_t>(i)];
    try {
      PictureReader read;
      read(file, image);
      if (image.width() >= least_width_ && image.height() >= least_height_) return true;
      complain(i, fmt::format("{}: {}x{} pixels, expected at least {}x{}: skipped", file.string(), image.width(),
                              image.height(), least_width_, least_height_));
    } catch (const std::runtime_error& e) {
      complain(i, std::string(e.what()) + ": skipped");
    }
    return false;
  }

  std::size_t skipped() const { return complained_.size(); }

 private:
  void complain(int i, const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (complained_.insert(i).second)
      fmt::print(stderr, "{}pavo: {}\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", message);
  }

  std::vector<fs::path> files_;
  int least_width_, least_height_;
  std::mutex mutex_;
  std::set<int> complained_;
};

/// `n` of the files, spread evenly, and the rest.
std::pair<std::vector<fs::path>, std::vector<fs::path>> held_out(const std::vector<fs::path>& files, std::size_t n) {
  std::pair<std::vector<fs::path>, std::vector<fs::path>> parts;
  for (std::size_t i = 0; i < files.size(); ++i)
    ((i * n) / files.size() != ((i + 1) * n) / files.size() ? parts.first : parts.second).push_back(files[i]);
  return parts;
}

std::string described(const TrainOptions& o) {
  return fmt::format(
      "seed {}, {} random negatives, up to {} rounds of hard examples above {} ({} an image, {} in all), C {}, "
      "positives "
      "{}, shifts {}, tone {}, epsilon {}, clip {}, fade {}, step {}, border {} cells",
      o.seed, o.random_negatives, o.max_rounds, o.hard_margin, o.hard_per_image, o.hard_total, o.C, o.positive_weight,
      o.shifts_px, o.features.tone == HogTone::linear ? "linear" : "square_root", o.features.epsilon, o.features.clip,
      o.features.fade, o.scale_step, o.border_cells);
}

/// Tells this training from others: its options, and the names and sizes of its pictures.
std::string fingerprint_of(const TrainCall& call, const PictureSet& positives, const PictureSet& negatives) {
  std::string all = described(call.options);
  std::error_code unreadable;  // its size is then the largest number; reading it tells what is wrong
  for (const PictureSet* set : {&positives, &negatives})
    for (const fs::path& file : set->files())
      all += fmt::format("\n{} {}", file.filename().string(), fs::file_size(file, unreadable));
  Sha256 sha;
  sha.update(all);
  return sha.hex();
}

/// One bar for each step.
class StepProgress {
 public:
  bool operator()(const TrainProgress& p) {
    if (step_ != p.step || p.done == 0) {
      bar_.reset();
      step_ = p.step;
      done_ = 0;
      if (p.total > 1) bar_.emplace(p.step, p.total, [this] { return done_.load(); });
    }
    done_ = p.done;
    if (p.done == p.total) bar_.reset();
    return true;
  }

 private:
  std::string step_;
  std::atomic<std::int64_t> done_{0};
  std::optional<Progress> bar_;
};

TrainData data_of(PictureSet& positives, PictureSet& negatives) {
  return {.positives = positives.size(),
          .negatives = negatives.size(),
          .load_positive = [&](int i, Image& image) { return positives.load(i, image); },
          .load_negative = [&](int i, Image& image) { return negatives.load(i, image); }};
}

void print_round(const RoundReport& r) {
  fmt::print("round {}: {} positives, {} negatives", r.round, r.positives, r.negatives);
  if (r.round > 0)
    fmt::print("; in {:.1f} million windows {} new hard examples, {} of them false alarms",
               static_cast<double>(r.windows) / 1e6, r.new_hard, r.new_false);
  fmt::print("\n");
  std::fflush(stdout);
}

/// Before hours are spent: can the model be written there?
void check_can_be_written(const std::string& state_file) {
  const bool there = fs::exists(state_file);
  std::FILE* file = std::fopen(state_file.c_str(), "ab");
  if (!file) throw std::system_error(errno, std::generic_category(), state_file + ": cannot be written");
  std::fclose(file);
  if (!there) fs::remove(state_file);
}

int train(const TrainCall& call) {
  const std::vector<fs::path> all_positives = picture_files({call.positives}),
                              all_negatives = picture_files({call.negatives});
  // As many of each, but a tenth of the positives at the most.
  const auto n = static_cast<std::size_t>(call.hold_out);
  if (n >= all_negatives.size())
    throw std::runtime_error(
        fmt::format("{}: {} pictures, and {} are to be kept out of the training: give more, or a smaller --hold-out",
                    call.negatives, all_negatives.size(), n));
  if (all_positives.size() < 2)
    throw std::runtime_error(
        fmt::format("{}: one picture: expected at least 2, one to train with and one to be kept out", call.positives));
  const std::string state_file = call.out + ".training";
  check_can_be_written(state_file);
  auto [validation_positives, train_positives] =
      held_out(all_positives, std::min(n, std::max<std::size_t>(1, all_positives.size() / 10)));
  auto [validation_negatives, train_negatives] = held_out(all_negatives, n);
  PictureSet positives(std::move(train_positives), 64, 128), negatives(std::move(train_negatives));
  PictureSet other_positives(std::move(validation_positives), 64, 128),
      other_negatives(std::move(validation_negatives));

  const std::string fingerprint = fingerprint_of(call, positives, negatives);
  TrainState state = read_train_state(state_file, fingerprint).value_or(TrainState{});
  if (!state.weights.empty()) fmt::print("going on after round {} of {}\n", state.round, state_file);

  std::atomic<bool> interrupted{false};
  const Signals signals([&] { interrupted = true; });
  tbb::task_arena arena(call.workers);
  StepProgress progress;
  const TrainCallbacks callbacks{.progress = [&](const TrainProgress& p) { return progress(p) && !interrupted; },
                                 .round =
                                     [&](const TrainState& s, const RoundReport& report) {
                                       write_train_state(state_file, s, fingerprint);
                                       print_round(report);
                                     }};
  if (!train_pedestrians(data_of(positives, negatives), call.options, arena, callbacks, state)) {
    fmt::print("stopped; the same command goes on where {} ends\n", state_file);
    return 1;
  }
  const Calibrated calibrated =
      calibrate_pedestrians(data_of(other_positives, other_negatives), call.options, arena, symmetric(state.weights));
  const std::string summary = fmt::format(
      "trained by pavo train: {}\n{} positives and their mirror images, {} pictures without people; kept out: {} and "
      "{}\n"
      "held out: {:.3f} false alarms a picture at the default threshold, which {:.1f} % of the people reach; "
      "log-average miss "
      "rate {:.3f}",
      described(call.options), positives.size(), negatives.size(), other_positives.size(), other_negatives.size(),
      calibrated.false_alarms_per_image, 100 * calibrated.found, calibrated.log_average_miss_rate);
  write_pedestrian_model(calibrated.model, call.out, summary);
  fs::remove(state_file);
  fmt::print("{}\n{}: written\n", summary, call.out);
  if (!state.complete) fmt::print("the last round still found false alarms: more --rounds would find more\n");
  if (const std::size_t skipped =
          positives.skipped() + negatives.skipped() + other_positives.skipped() + other_negatives.skipped())
    fmt::print("{} pictures could not be used\n", skipped);
  return 0;
}

}  // namespace

void register_train(CLI::App& app, int& status) {
  auto call = std::make_shared<TrainCall>();
  TrainOptions& o = call->options;
  CLI::App& command = *app.add_subcommand("train", "Train the pedestrian classifier");
  command.footer(
      "Example: pavo train INRIA/positive INRIA/negative --out pedestrian.txt\n"
      "Stops at Ctrl-C after the step it is at; the same command goes on (MODEL.training holds the state).");
  command
      .add_option("POSITIVES", call->positives, "pictures of at least 64x128 with a person, 96 px high, in the middle")
      ->type_name("DIR")
      ->required();
  command.add_option("NEGATIVES", call->negatives, "pictures of any size without people")->type_name("DIR")->required();
  command.add_option("--out", call->out, "the model")->type_name("MODEL")->required();
  command.add_option("--seed", o.seed, "of the random negatives (default 1)")->type_name("N");
  command
      .add_option("--hold-out", call->hold_out,
                  "negatives kept out, for the calibration (default 200; as many positives, up to a tenth)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000).description(""));
  command.add_option("--random", o.random_negatives, fmt::format("random negatives (default {})", o.random_negatives))
      ->type_name("N")
      ->check(CLI::Range(1, 10000000).description(""));
  command.add_option("--rounds", o.max_rounds, fmt::format("of hard examples, at most (default {})", o.max_rounds))
      ->type_name("N")
      ->check(CLI::Range(0, 1000).description(""));
  command.add_option("--hard", o.hard_total, "hard examples of a round, the hardest (default: all)")
      ->type_name("N")
      ->check(CLI::Range(0, 10000000).description(""));
  command.add_option("--hard-per-image", o.hard_per_image, fmt::format("of one image (default {})", o.hard_per_image))
      ->type_name("N")
      ->check(CLI::Range(1, 100000).description(""));
  command
      .add_option("--hard-margin", o.hard_margin,
                  fmt::format("margin from which on they are hard (default {})", o.hard_margin))
      ->type_name("M");
  command.add_option("--cost", o.C, fmt::format("C of the support vector machine (default {})", o.C))
      ->type_name("C")
      ->check(CLI::PositiveNumber.description(""));
  command
      .add_option("--positive-weight", o.positive_weight,
                  fmt::format("times C for positives (default {})", o.positive_weight))
      ->type_name("W")
      ->check(CLI::PositiveNumber.description(""));
  command
      .add_option("--epsilon", o.features.epsilon, fmt::format("of a block's norm (default {})", o.features.epsilon))
      ->type_name("E")
      ->check(CLI::PositiveNumber.description(""));
  command.add_option("--fade", o.features.fade, fmt::format("of a clipped block's norm (default {})", o.features.fade))
      ->type_name("F")
      ->check(CLI::PositiveNumber.description(""));
  command
      .add_option("--border", o.border_cells,
                  fmt::format("cells of 8 px that a window may reach beyond the image (default {})", o.border_cells))
      ->type_name("CELLS")
      ->check(CLI::Range(0, 16).description(""));
  command
      .add_option("--shift", o.shifts_px,
                  fmt::format("each positive also moved by so much to four sides (default {}: not)", o.shifts_px))
      ->type_name("PX")
      ->check(CLI::Range(0, 8).description(""));
  command.add_option("--workers", call->workers, "threads (default: one per core)")
      ->type_name("N")
      ->check(CLI::Range(1, 256).description(""));
  command.callback([call, &status] { status = train(*call); });
}

}  // namespace pavo
