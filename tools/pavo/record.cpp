#include "tools/pavo/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "drivers/calibration/write_calibration.h"
#include "drivers/recording/encode_png.h"
#include "drivers/recording/sequence_recorder.h"
#include "stages/decode/decode.h"
#include "tools/pavo/frame_feed.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/signals.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

struct RecordCall {
  std::string source, out, layout = "euroc", image = "png";
  FeedOptions feed;
  bool live = false;
  std::int64_t frames = 0;
  double seconds = 0;
  int encoders = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 16u));
};

// Of an image file, by its first bytes.
std::string_view extension_of(const std::vector<std::uint8_t>& file) {
  const auto begins = [&](std::string_view magic) {
    return file.size() >= magic.size() && std::memcmp(file.data(), magic.data(), magic.size()) == 0;
  };
  if (begins("\xFF\xD8")) return ".jpg";
  if (begins("\x89PNG")) return ".png";
  if (begins("P2") || begins("P5")) return ".pgm";
  if (begins("P3") || begins("P6")) return ".ppm";
  if (begins("BM")) return ".bmp";
  if (begins("II*") || begins("MM")) return ".tif";
  throw std::runtime_error("is no image file that pavo can read");
}

void encode_pgm(const Image& image, std::vector<std::uint8_t>& file) {
  const std::string header = fmt::format("P5\n{} {}\n255\n", image.width(), image.height());
  file.assign(header.begin(), header.end());
  for (int y = 0; y < image.height(); ++y) file.insert(file.end(), image.row(y), image.row(y) + image.width());
}

// What is an image file already stays as it is: a camera's JPEG decodes to the same pixels later. Anything else becomes
// the gray that `pavo run` would make of it.
EncodeFrame make_encoder(bool as_png) {
  struct Encoder {
    Decode decode;
    Decode::Scratch scratch;
    Image gray;
    EncodePng png;
  };
  return [as_png, e = std::make_shared<Encoder>()](const EncodedImage& frame,
                                                   std::vector<std::uint8_t>& file) -> std::string_view {
    if (frame.encoding == Encoding::file) {
      file.assign(frame.bytes.begin(), frame.bytes.end());
      return extension_of(file);
    }
    e->decode(frame, e->gray, e->scratch);
    if (as_png)
      e->png(e->gray.view(), file);
    else
      encode_pgm(e->gray, file);
    return as_png ? ".png" : ".pgm";
  };
}

std::vector<std::pair<std::string, std::string>> calibration_files(const std::optional<Camera>& camera,
                                                                   RecordLayout layout) {
  if (!camera) return {};
  if (layout == RecordLayout::euroc) return {{"sensor.yaml", euroc_sensor(*camera, 0)}};
  if (camera->lens == Lens::rectified) return {{"calib.txt", kitti_projections(*camera)}};
  return {{"camera.yaml", ros_camera_info(*camera, "camera")}};
}

void check_call(const RecordCall& call) {
  if (call.source.empty()) throw UsageError("SOURCE is empty: expected a camera such as /dev/video0, or a sequence");
  if (call.out.empty()) throw UsageError("--out is empty: expected the folder to record into");
}

// Everything about one recording that is going on.
class Recording {
 public:
  explicit Recording(const RecordCall& call, FrameFeed& feed)
      : call_(call),
        feed_(feed),
        recorder_(call.out,
                  {.layout = layout(),
                   .files = calibration_files(feed.camera(), layout()),
                   .encoders = call.encoders,
                   .wait_for_room = !is_camera(call.source) && !call.live},
                  [&] { return make_encoder(call.image == "png"); }) {}

  // The first error is thrown when everything else has been brought home.
  int run() {
    std::exception_ptr error;
    const auto start = std::chrono::steady_clock::now();
    try {
      record(start);
    } catch (...) {
      error = std::current_exception();
    }
    try {
      recorder_.finish();
    } catch (...) {
      if (!error) error = std::current_exception();
    }
    const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    write_report(wall_s, !error);
    if (error) std::rethrow_exception(error);
    if (recorder_.counts().written == 0) throw std::runtime_error(nothing_came());
    tell(wall_s);
    return 0;
  }

 private:
  RecordLayout layout() const { return call_.layout == "kitti" ? RecordLayout::kitti : RecordLayout::euroc; }

  void record(std::chrono::steady_clock::time_point start) {
    const Progress progress("record", feed_.frame_count(),
                            [this] { return static_cast<std::int64_t>(recorder_.counts().written); });
    EncodedImage image;
    std::int64_t t_ns = 0, taken = 0;
    while (!recorder_.failed() && !is_over(start, taken) && feed_.next(image, t_ns)) {
      recorder_.offer(image, t_ns);
      ++taken;
    }
  }

  bool is_over(std::chrono::steady_clock::time_point start, std::int64_t taken) const {
    if (call_.frames > 0 && taken >= call_.frames) return true;
    return call_.seconds > 0 &&
           std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() >= call_.seconds;
  }

  std::string nothing_came() const {
    const std::string why = feed_.counts().broken > 0 ? feed_.counts().first_broken : recorder_.first_failure();
    return call_.source + ": not one frame could be recorded" + (why.empty() ? "" : "; the first failure: " + why);
  }

  // Where the disk is full this cannot be written either; the error that is told is the first one.
  void write_report(double wall_s, bool must) {
    const RecordCounts r = recorder_.counts();
    const FeedCounts f = feed_.counts();
    const nlohmann::ordered_json report = {{"source", call_.source}, {"description", feed_.description()},
                                           {"layout", call_.layout}, {"frames", f.taken},
                                           {"written", r.written},   {"no_room", r.no_room},
                                           {"failed", r.failed},     {"broken", f.broken},
                                           {"lost_before", f.lost},  {"bytes", r.bytes},
                                           {"wall_s", wall_s}};
    try {
      write_whole_file(fs::path(call_.out) / "recording.json", report.dump(1) + "\n");
    } catch (...) {
      if (must) throw;
    }
  }

  void tell(double wall_s) const {
    const RecordCounts r = recorder_.counts();
    const FeedCounts f = feed_.counts();
    fmt::print("{}: {} frames written in {:.1f} s, {:.1f} a second, {:.1f} MB; from {}\n", call_.out, r.written, wall_s,
               static_cast<double>(r.written) / std::max(wall_s, 1e-9), static_cast<double>(r.bytes) * 1e-6,
               feed_.description());
    const auto warn = [](std::uint64_t count, const std::string& what) {
      if (count > 0) fmt::print(stderr, "pavo: warning: {} frames {}\n", count, what);
    };
    warn(r.no_room, "were not recorded: the encoders or the disk did not keep up");
    warn(r.failed, "were not recorded; the first: " + recorder_.first_failure());
    warn(f.broken, "were broken and are left out; the first: " + f.first_broken);
    warn(f.lost, "were lost before they came here: by the driver, or while the camera was away");
    warn(f.replaced_times, "had no time or one that did not increase; it is the time before and a period");
    if (!feed_.camera())
      fmt::print(stderr, "pavo: warning: no calibration is recorded, since none was given (--calibration FILE)\n");
  }

  const RecordCall& call_;
  FrameFeed& feed_;
  SequenceRecorder recorder_;
};

int record(const RecordCall& call) {
  check_call(call);
  std::atomic<FrameFeed*> running{nullptr};
  std::atomic<bool> interrupted{false};
  const Signals signals([&] {
    interrupted = true;
    if (FrameFeed* feed = running.load()) feed->interrupt();
  });
  FeedOptions options = call.feed;
  options.paced = call.live;
  const std::unique_ptr<FrameFeed> feed = open_feed(call.source, options);
  Recording recording(call, *feed);
  running = feed.get();
  if (interrupted) feed->interrupt();
  const int status = recording.run();
  running = nullptr;
  return status;
}

}  // namespace

void register_record(CLI::App& app, int& status) {
  auto call = std::make_shared<RecordCall>();
  CLI::App& command = *app.add_subcommand("record", "Record a camera as a sequence, lossless");
  command.footer(
      "Example: pavo record /dev/video0 --out drive/ --calibration camera.yaml\n"
      "Ctrl-C ends it. `pavo run drive/` replays it to the same bits; docs/cameras.md has more.");
  command.add_option("SOURCE", call->source, "a camera such as /dev/video0; or what `pavo run` reads")->required();
  command.add_option("--out", call->out, "a folder that is new or empty")->type_name("DIR")->required();
  command.add_option("--layout", call->layout, "euroc (default) or kitti")
      ->type_name("NAME")
      ->check(CLI::IsMember({"euroc", "kitti"}));
  command.add_option("--image", call->image, "png (default) or pgm: larger, and no work; a camera's JPEG stays JPEG")
      ->type_name("NAME")
      ->check(CLI::IsMember({"png", "pgm"}));
  command.add_option("--frames", call->frames, "end after so many")
      ->type_name("N")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 40).description(""));
  command.add_option("--seconds", call->seconds, "end after so long")
      ->type_name("S")
      ->check(CLI::Range(1e-3, 1e9).description(""));
  command.add_option("--encoders", call->encoders, "threads that write (default: one a core)")
      ->type_name("N")
      ->check(CLI::Range(1, 64).description(""));
  command.add_flag("--live", call->live, "a sequence's frames at their own times, as a camera would give them");
  add_feed_options(command, call->feed);
  command.callback([call, &status] { status = record(*call); });
}

}  // namespace pavo
