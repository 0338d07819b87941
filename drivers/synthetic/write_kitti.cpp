#include "drivers/synthetic/write_kitti.h"

#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "drivers/synthetic/synthetic_street.h"
#include "drivers/trajectories/append_file.h"
#include "drivers/trajectories/trajectory_files.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

void make_empty_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": cannot make this folder: " + error.message());
  const bool empty = fs::is_empty(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": cannot read this folder: " + error.message());
  if (!empty) throw std::runtime_error(folder.string() + ": is not empty; give a folder that is new or empty");
  if (!fs::create_directory(folder / "image_0", error))
    throw std::runtime_error((folder / "image_0").string() + ": cannot make this folder: " + error.message());
}

std::string kitti_calibration(const Camera& c) {
  std::string text;
  for (int i = 0; i < 4; ++i)
    text += format(
        "P%d: %.12e 0.000000000000e+00 %.12e 0.000000000000e+00 0.000000000000e+00 %.12e %.12e "
        "0.000000000000e+00 0.000000000000e+00 0.000000000000e+00 1.000000000000e+00 0.000000000000e+00\n",
        i, c.fx, c.cx, c.fy, c.cy);
  return text;
}

std::string ros_calibration(const Camera& c) {
  const bool fisheye = c.lens == Lens::equidistant;
  // plumb_bob is k1 k2 p1 p2 k3, the rational polynomial goes on with k4 k5 k6
  const bool rational = !fisheye && (c.distortion[5] != 0 || c.distortion[6] != 0 || c.distortion[7] != 0);
  const int count = fisheye ? 4 : rational ? 8 : 5;
  std::string d;
  for (int i = 0; i < count; ++i) d += format("%s%.12g", i ? ", " : "", c.distortion[static_cast<std::size_t>(i)]);
  const char* model = fisheye ? "equidistant" : rational ? "rational_polynomial" : "plumb_bob";
  return format("image_width: %d\nimage_height: %d\ncamera_name: synthetic\n", c.width, c.height) +
         format("camera_matrix:\n  rows: 3\n  cols: 3\n  data: [%.12g, 0, %.12g, 0, %.12g, %.12g, 0, 0, 1]\n", c.fx,
                c.cx, c.fy, c.cy) +
         format("distortion_model: %s\n", model) +
         format("distortion_coefficients:\n  rows: 1\n  cols: %d\n  data: [%s]\n", count, d.c_str()) +
         "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n" +
         format(
             "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [%.12g, 0, %.12g, 0, 0, %.12g, %.12g, 0, 0, 0, 1, 0]\n",
             c.fx, c.cx, c.fy, c.cy);
}

std::string people_lines(const std::string& image, const std::vector<SyntheticPerson>& people) {
  constexpr float kLeast = 0.05F, kHalf = 0.5F;
  std::string lines;
  for (const SyntheticPerson& p : people)
    if (p.visible_fraction >= kLeast)
      lines += format("%s,%.2f,%.2f,%.2f,%.2f,%d\n", image.c_str(), p.x, p.y, p.width, p.height,
                      p.visible_fraction < kHalf ? 1 : 0);
  return lines.empty() ? image + ",,,,,\n" : lines;
}

void write_png(const std::string& path, EncodedImage& image, std::vector<unsigned char>& png) {
  const cv::Mat pixels(image.height, image.width, CV_8U, image.bytes.data(), static_cast<std::size_t>(image.stride));
  if (!cv::imencode(".png", pixels, png, {cv::IMWRITE_PNG_COMPRESSION, 2}))
    throw std::runtime_error(path + ": this image cannot be encoded as PNG");
  AppendFile(path).append(std::string_view(reinterpret_cast<const char*>(png.data()), png.size()));
}

}  // namespace

int write_kitti_folder(const SyntheticOptions& options, const std::string& out_dir, const WriteProgress& progress) {
  check(options);
  const fs::path folder(out_dir);
  make_empty_folder(folder);
  SyntheticStreet street(options);
  const Camera& camera = *street.info().camera;
  if (camera.lens == Lens::rectified) write_whole_file((folder / "calib.txt").string(), kitti_calibration(camera));
  write_whole_file((folder / "camera.yaml").string(), ros_calibration(camera));
  AppendFile times((folder / "times.txt").string()), people((folder / "people.csv").string());
  people.append("image,x,y,width,height,ignore\n");
  KittiWriter poses((folder / "poses.txt").string());

  EncodedImage image;
  FrameStamp stamp;
  std::vector<unsigned char> png;
  int written = 0;
  while (street.read(image, stamp)) {
    write_png((folder / "image_0" / stamp.name).string(), image, png);
    times.append(format("%.9e\n", static_cast<double>(stamp.t_capture_ns) * 1e-9));
    poses.write(street.info().groundtruth->T_w_c[static_cast<std::size_t>(written)]);
    people.append(people_lines(stamp.name, street.people(written)));
    ++written;
    if (progress && !progress(written, options.frames)) break;
  }
  times.close();
  people.close();
  poses.close();
  return written;
}

}  // namespace pavo
