#include "tools/pavo/open_source.h"

#include "drivers/synthetic/synthetic_street.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

// The street has a camera and a truth of its own; the truth can only be left out.
class Street final : public Sequence {
 public:
  explicit Street(const Config& config) : street_({}), info_(street_.info()) {
    if (!config.source.calibration.empty())
      throw UsageError("--calibration " + config.source.calibration + ": the synthetic street has a camera of its own");
    if (config.source.groundtruth.empty()) return;
    if (config.source.groundtruth != "none")
      throw UsageError("--groundtruth " + config.source.groundtruth + ": the synthetic street's own, or none");
    info_.groundtruth.reset();
    info_.groundtruth_frames.clear();
    info_.groundtruth_source = "none, as asked";
  }
  const SequenceInfo& info() const override { return info_; }
  std::optional<FrameStamp> peek() override { return street_.peek(); }
  bool read(EncodedImage& image, FrameStamp& stamp) override { return street_.read(image, stamp); }
  bool skip() override { return street_.skip(); }

 private:
  SyntheticStreet street_;
  SequenceInfo info_;
};

}  // namespace

std::unique_ptr<Sequence> open_source(const std::string& source, const Config& config) {
  if (source == "synthetic") return std::make_unique<Street>(config);
  return open_sequence(source, {.calibration = config.source.calibration,
                                .groundtruth = config.source.groundtruth,
                                .rate_hz = config.source.rate_hz});
}

}  // namespace pavo
