#include "tools/pavo/synth.h"

#include <fmt/format.h>

#include <atomic>
#include <memory>

#include "drivers/synthetic/write_kitti.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/signals.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

struct SynthCall {
  std::string out;
  std::string lens = "none";
  bool no_people = false;
  SyntheticOptions options;
};

int synth(SynthCall call) {
  call.options.people = !call.no_people;
  if (call.lens == "radial-tangential") {
    call.options.lens = Lens::radial_tangential;
    call.options.distortion = {-0.28, 0.07, 0.0005, -0.0003};
  } else if (call.lens == "equidistant") {
    call.options.lens = Lens::equidistant;
    call.options.distortion = {-0.02, 0.004, -0.001, 0.0002};
  }
  try {
    check(call.options);
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
  std::atomic<bool> interrupted{false};
  const Signals signals([&] { interrupted = true; });
  std::atomic<std::int64_t> done{0};
  int written = 0;
  {
    const Progress progress("synth", call.options.frames, [&] { return done.load(); });
    written = write_kitti_folder(call.options, call.out, [&](int frames_written, int) {
      done = frames_written;
      return !interrupted;
    });
  }
  fmt::print("{}: {} frames of {}x{}, seed {}, with poses.txt, times.txt, people.csv and the calibration\n", call.out,
             written, call.options.width, call.options.height, call.options.seed);
  return 0;
}

}  // namespace

void register_synth(CLI::App& app, int& status) {
  auto call = std::make_shared<SynthCall>();
  SyntheticOptions& o = call->options;
  CLI::App& command = *app.add_subcommand("synth", "Write the synthetic street as a KITTI folder");
  command.footer("Example: pavo synth --out street/ --seed 7 --companions 10 && pavo run street/ --out out/");
  command.add_option("--out", call->out, "the folder to write")->type_name("DIR")->required();
  command.add_option("--seed", o.seed, "another seed is another street")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber.description(""));
  command.add_option("--frames", o.frames, "how many (default 300)")->type_name("N");
  command.add_option("--width", o.width, "of the images (default 1226)")->type_name("PX");
  command.add_option("--height", o.height, "of the images (default 370)")->type_name("PX");
  command.add_option("--speed", o.speed_mps, "of the camera (default 8)")->type_name("M/S");
  command.add_option("--density", o.density, "of the passers-by (default 1)")->type_name("FACTOR");
  command.add_option("--hills", o.hills_m, "the street rises and falls by so much (default 0)")->type_name("M");
  command.add_option("--companions", o.companions, "people who walk along with the camera (default 0)")->type_name("N");
  command.add_option("--noise", o.noise_sigma, "of the sensor, in gray levels (default 1)")->type_name("SIGMA");
  command.add_option("--lens", call->lens, "none, radial-tangential or equidistant")
      ->type_name("NAME")
      ->check(CLI::IsMember({"none", "radial-tangential", "equidistant"}));
  command.add_flag("--no-people", call->no_people, "an empty street");
  command.add_flag("--loop", o.loop, "a closed street, driven round and round");
  command.callback([call, &status] { status = synth(*call); });
}

}  // namespace pavo
