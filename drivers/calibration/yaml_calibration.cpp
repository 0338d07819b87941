#include "drivers/calibration/yaml_calibration.h"

#include "drivers/calibration/kitti_file.h"
#include "drivers/calibration/text.h"
#include "drivers/calibration/yaml_file.h"

namespace pavo {
namespace {

Lens lens_named(const YamlFile& file, const std::string& key) {
  const std::string model = file.text(key);
  for (const char* name : {"radial-tangential", "radtan", "plumb_bob", "rational_polynomial"}) {
    if (model == name) return Lens::radial_tangential;
  }
  for (const char* name : {"equidistant", "equi", "fisheye"}) {
    if (model == name) return Lens::equidistant;
  }
  if (model.empty() || model == "none") return Lens::rectified;
  fail_at(file.name(), file.place(key).line,
          key + " is " + quoted(model) +
              ": expected radial-tangential, plumb_bob, rational_polynomial, equidistant, fisheye or none");
}

void read_distortion(Camera& camera, const YamlFile& file, Lens lens) {
  const auto key = file.find({"distortion_coefficients", "Distortion_Coefficients", "distortion_coeffs", "dist_coeffs",
                              "dist_coeff", "distCoeffs", "D", "d"});
  if (!key && lens == Lens::rectified) return;
  if (!key)
    file.need({"distortion_coefficients"},
              "k1 k2 p1 p2 [k3 [k4 k5 k6]], or k1 k2 k3 k4 of a fisheye (all 0: no distortion)");
  set_distortion(camera, lens, file.numbers(*key), file.place(*key));
}

SE3 read_pose(const YamlFile& file, const std::string& key) {
  const auto m = file.numbers(key, 16);
  const Place place = file.place(key);
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) {
    fail_at(place.file, place.line, key + " does not end with the row 0 0 0 1: expected a 4x4 rigid motion");
  }
  Eigen::Matrix3d R;
  R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  return {nearest_rotation(R, place.file, place.line, key), {m[3], m[7], m[11]}};
}

Calibration from_euroc(const YamlFile& file) {
  const auto must_be = [&](const char* key, const char* value) {
    if (!file.find({key}) || file.text(key) == value) return;
    fail_at(file.name(), file.place(key).line,
            std::string(key) + " is " + quoted(file.text(key)) + ": expected " + value);
  };
  must_be("sensor_type", "camera");
  must_be("camera_model", "pinhole");

  Calibration calibration;
  Camera& camera = calibration.camera;
  const auto k = file.numbers(file.need({"intrinsics"}, "'intrinsics: [fu, fv, cu, cv]' in pixels"), 4);
  set_intrinsics(camera, k[0], k[1], k[2], k[3], file.place("intrinsics"));
  const auto size = file.numbers(file.need({"resolution"}, "'resolution: [width, height]'"), 2);
  set_size(camera, size[0], size[1], file.place("resolution"));
  const Lens lens = lens_named(
      file, file.need({"distortion_model"}, "'distortion_model: radial-tangential' or 'equidistant' (or none)"));
  read_distortion(camera, file, lens);
  if (file.find({"T_BS"})) calibration.T_b_c = read_pose(file, "T_BS");
  calibration.source = file.name() + ", intrinsics";
  return calibration;
}

/// The message CameraInfo may describe a part of the sensor, or merged pixels; then K is not that of the image.
void refuse_crop(const YamlFile& file) {
  for (const char* key : {"binning_x", "binning_y"}) {
    if (file.find({key}) && file.number(key) > 1) {
      fail_at(file.name(), file.place(key).line,
              std::string(key) + " is not supported: calibrate at the size of the images");
    }
  }
}

Lens lens_of_matrices(const YamlFile& file) {
  if (const auto key = file.find({"distortion_model"})) return lens_named(file, *key);
  const auto fisheye = file.find({"fisheye_model", "Fisheye_Model"});
  return fisheye && file.number(*fisheye) != 0 ? Lens::equidistant : Lens::radial_tangential;
}

Calibration from_matrices(const YamlFile& file, const std::string& key) {
  refuse_crop(file);
  Calibration calibration;
  Camera& camera = calibration.camera;
  set_intrinsics(camera, file.numbers(key, 9), 3, file.place(key));

  const auto width = file.need({"image_width", "image_Width", "imageWidth", "width"}, "'image_width: N' in pixels");
  const auto height =
      file.need({"image_height", "image_Height", "imageHeight", "height"}, "'image_height: N' in pixels");
  set_size(camera, file.number(width), file.number(height), file.place(width));

  const Lens lens = lens_of_matrices(file);
  // ROS leaves the model's name empty where it is the usual one.
  read_distortion(camera, file, lens == Lens::rectified ? Lens::radial_tangential : lens);
  const bool has_projection = file.find({"projection_matrix", "P", "p"}).has_value();
  calibration.source = file.name() + ", " + key + (has_projection ? " and distortion of the raw image (not P)" : "");
  return calibration;
}

}  // namespace

Calibration parse_yaml_calibration(std::string_view text, const std::string& name) {
  const YamlFile file(text, name);
  if (file.find({"intrinsics", "camera_model"})) return from_euroc(file);
  const auto key = file.find({"camera_matrix", "Camera_Matrix", "cameraMatrix", "CameraMatrix", "K", "k"});
  if (key) return from_matrices(file, *key);
  fail_at(name, 0,
          "has no camera: expected 'intrinsics' (EuRoC), 'camera_matrix' or 'K' (ROS, OpenCV), or 'P0:' (KITTI)");
}

}  // namespace pavo
