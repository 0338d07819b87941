#include "drivers/v4l2/list_devices.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace pavo::v4l2 {
namespace {

FoundDevice::Size size_of(const Device& device, std::uint32_t fourcc, const SizeRange& range) {
  FoundDevice::Size size{.range = range, .rates_hz = device.listed_rates_hz(fourcc, range.largest)};
  if (!size.rates_hz.empty()) return size;
  if (const auto rates = device.rates(fourcc, range.largest)) {
    size.rates_hz = {rates->slowest_hz, rates->fastest_hz};
    size.any_between = true;
  }
  return size;
}

}  // namespace

FoundDevice describe_device(SystemCalls& system, const std::string& path) {
  FoundDevice found{.path = path};
  try {
    const Device device(system, path);
    found.name = device.name();
    for (const OfferedFormat& offered : device.formats()) {
      FoundDevice::Format format{.fourcc = offered.fourcc,
                                 .description = offered.description,
                                 .readable = pixel_format_of(offered.fourcc).has_value()};
      for (const SizeRange& range : offered.sizes) format.sizes.push_back(size_of(device, offered.fourcc, range));
      found.formats.push_back(std::move(format));
    }
    found.controls = controls_of(device);
  } catch (const DeviceError& e) {
    found.problem = e.what();
  }
  return found;
}

std::vector<std::string> device_nodes(const std::string& folder) {
  constexpr std::string_view kPrefix = "video";
  std::vector<std::pair<int, std::string>> nodes;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    const std::string_view number = std::string_view(name).substr(std::min(name.size(), kPrefix.size()));
    constexpr std::size_t kLongest = 6;
    if (!name.starts_with(kPrefix) || number.empty() || number.size() > kLongest ||
        !std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); }))
      continue;
    nodes.emplace_back(std::stoi(std::string(number)), entry.path().string());
  }
  std::sort(nodes.begin(), nodes.end());
  std::vector<std::string> paths;
  paths.reserve(nodes.size());
  for (auto& [number, path] : nodes) paths.push_back(std::move(path));
  return paths;
}

}  // namespace pavo::v4l2
