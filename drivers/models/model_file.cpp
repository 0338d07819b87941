#include "drivers/models/model_file.h"

#include "drivers/trajectories/append_file.h"

namespace pavo {

PedestrianModel read_pedestrian_model(const std::filesystem::path& file) {
  constexpr std::size_t kLargest = std::size_t{16} << 20;
  return parse_pedestrian_model(read_whole_file(file.string(), kLargest), file.string());
}

void write_pedestrian_model(const PedestrianModel& model, const std::filesystem::path& file, std::string_view comment) {
  write_whole_file(file.string(), pedestrian_model_text(model, comment));
}

}  // namespace pavo
