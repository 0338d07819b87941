// `--publish`: the poses of a run to whoever listens, as soon as they are there.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "drivers/publishing/publisher.h"
#include "engine/clock.h"
#include "engine/frame_info.h"
#include "pavo/frame.h"

namespace pavo {

/// Called by the delivery; never blocks. Does nothing where nothing is to be published.
class RunPublishing {
 public:
  /// `where`: as open_publisher() has it, or "": nowhere. Throws UsageError, or std::runtime_error.
  RunPublishing(const std::string& where, const Clock& clock);

  void deliver(const Frame& frame, const FrameInfo& info);

  /// Null where nothing was to be published.
  nlohmann::ordered_json report() const;
  std::vector<std::string> warnings() const;

 private:
  std::string where_;
  const Clock& clock_;
  std::unique_ptr<Publisher> publisher_;
  std::string line_;
};

}  // namespace pavo
