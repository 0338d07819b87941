// What the engine knows of a frame: which one it is, when it was taken, what became of it.
#pragma once

#include <cstdint>
#include <string_view>

namespace pavo {

struct FrameInfo {
  std::uint64_t sequence = 0;     ///< order of admission: 0, 1, 2, ... without a hole (set by the engine)
  std::int64_t source_index = 0;  ///< the source's own count
  std::int64_t t_capture_ns = 0;  ///< the source's own time
  std::int64_t t_arrival_ns = 0;  ///< engine clock: when it was there to be taken; end-to-end latency starts here
  std::int64_t t_sensor_ns = 0;   ///< engine clock: when the sensor saw it; age starts here. 0: as t_arrival_ns
  std::uint64_t stale = 0;        ///< a device's frames that nobody read, since this one came: counted as dropped
  std::uint64_t gap = 0;          ///< frames lost between the frame before and this one; the source fills in what the
                                  ///< driver lost, the engine adds what it dropped
};

/// How a frame ended. Of several stages that failed, the first in the order of declaration.
struct Outcome {
  bool failed = false;
  std::string_view stage;  ///< valid during the delivery
  std::string_view message;
};

}  // namespace pavo
