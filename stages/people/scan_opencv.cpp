#include "stages/people/scan_opencv.h"

#include <stdexcept>

#include "stages/people/person_window.h"
#include "stages/people/suppress.h"

namespace pavo {

ScanPeopleOpencv::ScanPeopleOpencv(const ScanOpencvOptions& options) : options_(options) {
  if (options_.stride_px < 8 || options_.stride_px % 8 != 0)
    throw std::invalid_argument("scan: stride_px must be a positive multiple of 8");
  if (!(options_.scale_step > 1)) throw std::invalid_argument("scan: scale_step must be larger than 1");
  hog_.setSVMDetector(cv::HOGDescriptor::getDefaultPeopleDetector());
}

void ScanPeopleOpencv::operator()(const Image& image, Detections& detections, Scratch& scratch) const {
  detections.clear();
  if (image.width() < hog_.winSize.width || image.height() < hog_.winSize.height) return;

  // cv::Mat has no borrowed constant pixels; detectMultiScale only reads them.
  const cv::Mat pixels(image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
                       static_cast<std::size_t>(image.stride()));
  const cv::Size stride(options_.stride_px, options_.stride_px);
  hog_.detectMultiScale(pixels, scratch.windows, scratch.margins, static_cast<double>(options_.threshold), stride,
                        cv::Size(), options_.scale_step, 0.0);
  for (std::size_t i = 0; i < scratch.windows.size(); ++i) {
    const cv::Rect2f w(scratch.windows[i]);
    detections.push_back(person_in_window(w.x, w.y, w.width, w.height, static_cast<float>(scratch.margins[i])));
  }
  suppress_non_maxima(detections, options_.largest_share);
}

}  // namespace pavo
