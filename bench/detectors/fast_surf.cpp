// pavo's own: FAST corners spread over a grid, SURF-64, exact mutual nearest neighbours.
#include "bench/detectors/surf_features.h"
#include "stages/features/extract.h"

namespace pavo::bench {
namespace {

class FastSurf final : public SurfFeatures {
 public:
  explicit FastSurf(bool oriented) : oriented_(oriented) {}
  std::string name() const override { return oriented_ ? "FAST (grid) + SURF, oriented" : "FAST (grid) + SURF"; }

  void detect(const Image& image, Found& found) override {
    const FeatureOptions options{.max_features = kMaxKeypoints, .descriptors = false};
    run(detector_, options, image, found);
  }
  void extract(const Image& image, Found& found) override {
    const FeatureOptions options{.max_features = kMaxKeypoints, .oriented = oriented_};
    run(extractor_, options, image, found);
  }

 private:
  struct Stage {
    std::unique_ptr<ExtractFeatures> extract;
    int width = 0, height = 0;
    ExtractFeatures::Scratch scratch;
  };

  static void run(Stage& stage, const FeatureOptions& options, const Image& image, Found& found) {
    if (stage.width != image.width() || stage.height != image.height()) {
      stage.extract = std::make_unique<ExtractFeatures>(options, image.width(), image.height());
      stage.width = image.width(), stage.height = image.height();
    }
    (*stage.extract)(image, found.features, stage.scratch);
  }

  bool oriented_;
  Stage detector_, extractor_;
};

}  // namespace

void add_fast_surf(Competitors& to) {
  for (const bool oriented : {false, true}) to.push_back(std::make_unique<FastSurf>(oriented));
}

}  // namespace pavo::bench
