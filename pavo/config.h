// Everything that can be set, with its default: one plain struct, one list of its keys.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace pavo {

/// Defaults are for a vehicle's camera on a machine with two cores. "" and 0 mean "by itself" where the text says so.
struct Config {
  struct SourceSettings {
    std::string calibration;  ///< a file; "": the source's own
    std::string groundtruth;  ///< a file; "": the source's own; "none": none
    double rate_hz = 0;       ///< gives times to a source without any; 0: none
    std::string mode = "auto";
  } source;

  struct CameraSettings {
    double height_m = 0;   ///< above the ground; 0: not known
    double pitch_rad = 0;  ///< of the optical axis above the horizon (negative: it looks down), as far as it is known
  } camera;

  struct DeviceSettings {
    std::string format = "auto";  ///< "YUYV"; auto: the one that pavo likes best of those that are fast enough
    int width = 0, height = 0;    ///< 0: the calibration's
    std::string controls;         ///< "name=value, name=value", set in this order
    int buffers = 4;              ///< that the driver fills
    double patience_s = 2;        ///< without a frame for so long, the camera is closed and opened again
    double give_up_s = 0;         ///< after so long away the run ends; 0: never
  } device;

  struct EngineSettings {
    int workers = 0;  ///< 0: as many as there are cores
    int slots = 0;
    int live_credits = 0;
    int failures_in_a_row = 30;
    double stage_limit_s = 30;  ///< 0: none
    double source_limit_s = 30;
    double latency_budget_ms = 0;
    int background_nice = 10;
    std::string affinity;  ///< "odometry=0 scan=0,1"
    std::string cpus;      ///< "0,1"
    int fifo_priority = 0;
    bool lock_memory = false;
    std::string simd = "auto";
  } engine;

  struct UndistortSettings {
    double alpha = 0;
  } undistort;

  struct FeatureSettings {
    int max_features = 2000;
    bool oriented = false;
  } features;

  struct PeopleSettings {
    bool enabled = true;
    std::string model;               ///< a file; "": the one that is built in
    double threshold = 0.07;         ///< smallest probability of a detection; negative: the model's own
    double ground_slack_rad = 0.04;  ///< how far from where a level ground is people's feet may be seen
    double mask_width = 1.25;        ///< of the outline whose features are dropped, times the box's
    double mask_height = 1;
    std::string mask_shape = "box";
    bool sizes_in_turn = true;  ///< half of the people's sizes are looked for in each frame
    bool put_back = true;  ///< matches in outlines that move as the street does are used (frame-to-frame, descriptor)
  } people;

  struct OdometrySettings {
    std::string estimator = "auto";  ///< uses_keyframes() says which
    std::string tracker = "descriptor";
    std::string scale = "unit";
    std::uint64_t seed = 0;
    double match_ratio = 0.85;
    int min_matches = 20;
    bool refine_calibration = true;  ///< of the keyframe estimator
    bool compare = false;
  } odometry;

  struct OutputSettings {
    std::string publish;  ///< -, unix:PATH or udp:HOST:PORT: where each pose is sent; "": nowhere
  } output;
};

/// Whether the scale comes from the camera's height (odometry.scale = "camera-height[=M]").
bool scale_from_camera_height(const Config& config);
/// Whether the keyframe estimator is used: "auto" is that, but with the tracker "klt", which is frame-to-frame's.
bool uses_keyframes(const Config& config);
/// Throws std::runtime_error, one line, where the tracker is not one of the estimator's.
void check_estimator(const Config& config);
/// Puts the M of "camera-height=M" where it belongs, into camera.height_m. Throws std::runtime_error where the scale
/// needs a height and none is told, or two different ones.
void settle_camera_height(Config& config);

/// One key of the config: where its value lives, what it may be, what it is for.
struct Setting {
  std::string_view key;  ///< "section.name"
  std::variant<bool*, int*, double*, std::uint64_t*, std::string*> value;
  std::string_view help;
  std::vector<std::string_view> choices;  ///< of a string; empty: any
  double minimum = 0, maximum = 0;        ///< of a number; equal: any
};

/// All keys, in the order of the documentation; the pointers lead into `config`.
std::vector<Setting> settings(Config& config);

/// Reads a TOML file over what `config` holds. Throws std::runtime_error with one line (file:line, key, what was
/// expected; for a key that does not exist the nearest one that does).
void read_config(const std::string& path, Config& config);
/// The same from memory; `name` stands for the file in messages.
void parse_config(std::string_view text, const std::string& name, Config& config);

/// Sets one key from text, as an option of the command line does. Throws std::runtime_error that names `option`.
void set_from_text(Config& config, std::string_view key, const std::string& text, const std::string& option);

nlohmann::ordered_json to_json(const Config& config);

}  // namespace pavo
