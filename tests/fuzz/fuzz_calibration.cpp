#include <cmath>
#include <string_view>

#include "drivers/calibration/calibration.h"
#include "tests/fuzz/fuzz.h"

/// The first byte chooses the hints.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pavo;
  if (size == 0) return 0;
  CalibrationHints hints;
  if (data[0] & 4) hints.kitti_camera = data[0] & 3;
  if (data[0] & 8) {
    hints.width = 1392;
    hints.height = 512;
  }
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  fuzz::try_parse([&] { return parse_calibration(text, fuzz::kName, hints); },
                  [](const Calibration& calibration) {
                    const Camera& c = calibration.camera;
                    fuzz::require(c.fx >= 1 && c.fy >= 1 && c.fx <= 1e6 && c.fy <= 1e6, "focal lengths are plausible");
                    fuzz::require(std::isfinite(c.cx) && std::isfinite(c.cy), "the principal point is finite");
                    fuzz::require((c.width > 0) == (c.height > 0), "the size is there or is not");
                    for (const double k : c.distortion) fuzz::require(std::isfinite(k), "coefficients are finite");
                    if (!calibration.T_b_c) return;
                    const Eigen::Matrix3d& R = calibration.T_b_c->R;
                    fuzz::require((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < 1e-9,
                                  "T_b_c is a rigid motion");
                    fuzz::require(calibration.T_b_c->t.allFinite(), "T_b_c is finite");
                  });
  return 0;
}
