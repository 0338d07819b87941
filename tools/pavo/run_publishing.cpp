#include "tools/pavo/run_publishing.h"

#include <fmt/format.h>

#include "drivers/publishing/pose_line.h"
#include "tools/pavo/usage_error.h"

namespace pavo {

RunPublishing::RunPublishing(const std::string& where, const Clock& clock) : where_(where), clock_(clock) {
  if (where.empty()) return;
  if (const std::string wrong = invalid_publish_target(where); !wrong.empty())
    throw UsageError("--publish (output.publish) " + wrong);
  publisher_ = open_publisher(where);
}

void RunPublishing::deliver(const Frame& frame, const FrameInfo& info) {
  if (!publisher_) return;
  const std::int64_t seen_ns = info.t_sensor_ns != 0 ? info.t_sensor_ns : info.t_arrival_ns;
  line_.clear();
  append_pose_line(line_, {.frame = info.source_index,
                           .t_capture_ns = info.t_capture_ns,
                           .age_ms = static_cast<double>(clock_.now_ns() - seen_ns) * 1e-6,
                           .T_world_camera = frame.pose.T_w_c,
                           .quality = name_of(frame.pose.quality)});
  publisher_->publish(line_);
}

nlohmann::ordered_json RunPublishing::report() const {
  if (!publisher_) return {};
  const PublishCounts& c = publisher_->counts();
  return {{"where", where_}, {"lines", c.lines},   {"sent", c.sent},
          {"lost", c.lost},  {"unread", c.unread}, {"readers_ever", c.connected}};
}

std::vector<std::string> RunPublishing::warnings() const {
  if (!publisher_ || publisher_->counts().lost == 0) return {};
  return {fmt::format("--publish {}: {} of {} lines were lost, since a reader was slow or gone", where_,
                      publisher_->counts().lost, publisher_->counts().lost + publisher_->counts().sent)};
}

}  // namespace pavo
