// One frame of odometry, from the bytes of the camera to the pose: the parts that the stages read and write.
#pragma once

#include <optional>
#include <string>

#include "engine/parts.h"
#include "stages/features/features.h"
#include "stages/map/map_messages.h"
#include "stages/people/people.h"
#include "stages/people/standing_prior.h"
#include "stages/pose/pose_result.h"
#include "types/encoded_image.h"
#include "types/image.h"

namespace pavo {

struct Frame {
  std::string name;      ///< of the frame in its source, for messages
  EncodedImage encoded;  ///< as the source delivers it
  Image raw;             ///< decoded, 8-bit gray
  Image image;           ///< without the lens's distortion
  Features features;
  std::optional<StandingPrior> standing;  ///< where the scan looks for people; nothing: everywhere
  Detections detections;                  ///< what the scan saw
  bool scanned = true;                    ///< false: it was late (engine.latency_budget_ms), and nobody looked
  People people;                          ///< who is there
  PoseResult pose;
  Delayed<GroundAttitude> attitude;  ///< what that says of the ground (--estimator frame-to-frame)
  KeyframeRecord keyframe;           ///< what the odometry tells the map (--estimator keyframe)
  Delayed<MapUpdate> map;            ///< what that makes of it
  PoseResult geometric;              ///< the same without removing people (--compare)
  KeyframeRecord geometric_keyframe;
  Delayed<MapUpdate> geometric_map;
};

}  // namespace pavo
