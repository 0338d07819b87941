// Corners of the previous frame, followed into the current one: the thesis's other way.
#include "stages/matches/klt.h"

#include "bench/detectors/corner_detectors.h"
#include "stages/features/extract.h"

namespace pavo::bench {
namespace {

class Followed : public Competitor {
 public:
  void extract(const Image& image, Found& found) override { detect(image, found); }
  void match(const View& previous, const View& current, PointPairs& pairs) override {
    track_(previous.image, current.image, previous.found.features.keypoints, {}, tracks_, scratch_);
    pairs.assign(tracks_.pairs.begin(), tracks_.pairs.end());
  }
  std::size_t count(const Found& found) const override { return found.features.size(); }
  bool tracks() const override { return true; }

 private:
  TrackKlt track_;
  TrackKlt::Scratch scratch_;
  Tracks tracks_;
};

class FastKlt final : public Followed {
 public:
  std::string name() const override { return "FAST (grid) + KLT"; }
  void detect(const Image& image, Found& found) override {
    if (!extract_ || width_ != image.width() || height_ != image.height()) {
      const FeatureOptions options{.max_features = kMaxKeypoints, .descriptors = false};
      extract_ = std::make_unique<ExtractFeatures>(options, image.width(), image.height());
      width_ = image.width(), height_ = image.height();
    }
    (*extract_)(image, found.features, scratch_);
  }

 private:
  std::unique_ptr<ExtractFeatures> extract_;
  ExtractFeatures::Scratch scratch_;
  int width_ = 0, height_ = 0;
};

class ShiTomasiKlt final : public Followed {
 public:
  std::string name() const override { return "cv Shi-Tomasi + KLT"; }
  void detect(const Image& image, Found& found) override {
    detector_->detect(mat_of(image), found.keypoints);
    found.features.keypoints.clear();
    for (const cv::KeyPoint& keypoint : found.keypoints)
      found.features.keypoints.push_back({.x = keypoint.pt.x, .y = keypoint.pt.y, .response = keypoint.response});
  }

 private:
  cv::Ptr<cv::Feature2D> detector_ = shi_tomasi_detector();
};

}  // namespace

void add_klt(Competitors& to) {
  to.push_back(std::make_unique<FastKlt>());
  to.push_back(std::make_unique<ShiTomasiKlt>());
}

}  // namespace pavo::bench
