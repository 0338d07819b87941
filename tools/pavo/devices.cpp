#include "tools/pavo/devices.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "drivers/v4l2/list_devices.h"

namespace pavo {
namespace {

using v4l2::Control;
using v4l2::ControlKind;
using v4l2::FoundDevice;
using Json = nlohmann::ordered_json;

struct DevicesCall {
  std::string device;
  bool json = false;
};

std::string size_text(const v4l2::FrameSize& size) {
  return fmt::format("{}x{}", size.width, size.height);
}

std::string rates_text(const FoundDevice::Size& size) {
  if (size.rates_hz.empty()) return "rates unknown";
  if (size.any_between) return fmt::format("{:.4g} to {:.4g} Hz", size.rates_hz.front(), size.rates_hz.back());
  std::string text;
  for (const double rate : size.rates_hz) text += fmt::format("{}{:.4g}", text.empty() ? "" : ", ", rate);
  return text + " Hz";
}

std::string value_text(const Control& control) {
  if (control.kind == ControlKind::yes_no) return control.value ? "true" : "false";
  if (control.kind == ControlKind::button) return "a button: set it to 1";
  if (control.kind == ControlKind::other) return "not a number";
  for (const auto& [number, name] : control.choices)
    if (number == control.value) return fmt::format("{} ({})", number, name);
  return std::to_string(control.value);
}

std::string range_text(const Control& control) {
  std::string text;
  if (control.kind == ControlKind::menu) {
    for (const auto& [number, name] : control.choices)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", number, name);
  } else if (control.kind == ControlKind::whole_number) {
    text = fmt::format("{} to {}{}, default {}", control.minimum, control.maximum,
                       control.step > 0 ? fmt::format(", step {}", control.step) : "", control.fallback);
  }
  if (control.read_only) text += text.empty() ? "read only" : "; read only";
  if (control.inactive) text += text.empty() ? "without effect now" : "; without effect now";
  return text;
}

void print_table(const FoundDevice& device) {
  if (!device.problem.empty()) {
    fmt::print("{}\n", device.problem);
    return;
  }
  fmt::print("{}  {} ({}, {})\n", device.path, device.name.card, device.name.driver, device.name.bus);
  for (const FoundDevice::Format& format : device.formats) {
    fmt::print("  {:<5} {}{}\n", v4l2::fourcc_text(format.fourcc), format.description,
               format.readable ? "" : "  (pavo does not read it)");
    for (const FoundDevice::Size& size : format.sizes)
      fmt::print("        {:<10} {}\n",
                 size_text(size.range.smallest) + (size.range.is_one() ? "" : " to " + size_text(size.range.largest)),
                 rates_text(size));
  }
  if (!device.controls.empty()) fmt::print("  controls\n");
  for (const Control& control : device.controls)
    fmt::print("        {:<32} {:<24} {}\n", control.name, value_text(control), range_text(control));
}

Json json_of(const FoundDevice::Size& size) {
  Json json = {{"width", size.range.largest.width}, {"height", size.range.largest.height}};
  if (!size.range.is_one()) {
    json["smallest"] = {size.range.smallest.width, size.range.smallest.height};
    json["step"] = {size.range.step.width, size.range.step.height};
  }
  json[size.any_between ? "rates_hz_from_to" : "rates_hz"] = size.rates_hz;
  return json;
}

std::string_view kind_text(ControlKind kind) {
  switch (kind) {
    case ControlKind::whole_number:
      return "number";
    case ControlKind::yes_no:
      return "boolean";
    case ControlKind::menu:
      return "menu";
    case ControlKind::button:
      return "button";
    case ControlKind::other:
      return "other";
  }
  return "?";
}

Json json_of(const Control& control) {
  Json json = {{"name", control.name},        {"title", control.title},      {"kind", kind_text(control.kind)},
               {"value", control.value},      {"minimum", control.minimum},  {"maximum", control.maximum},
               {"step", control.step},        {"default", control.fallback}, {"read_only", control.read_only},
               {"inactive", control.inactive}};
  for (const auto& [number, name] : control.choices) json["choices"].push_back({{"value", number}, {"name", name}});
  return json;
}

Json json_of(const FoundDevice& device) {
  Json json = {{"path", device.path}};
  if (!device.problem.empty()) {
    json["problem"] = device.problem;
    return json;
  }
  json["name"] = device.name.card;
  json["driver"] = device.name.driver;
  json["bus"] = device.name.bus;
  json["formats"] = Json::array();
  for (const FoundDevice::Format& format : device.formats) {
    Json sizes = Json::array();
    for (const FoundDevice::Size& size : format.sizes) sizes.push_back(json_of(size));
    json["formats"].push_back({{"format", v4l2::fourcc_text(format.fourcc)},
                               {"description", format.description},
                               {"readable", format.readable},
                               {"sizes", sizes}});
  }
  json["controls"] = Json::array();
  for (const Control& control : device.controls) json["controls"].push_back(json_of(control));
  return json;
}

int devices(const DevicesCall& call) {
  v4l2::Kernel kernel;
  std::vector<FoundDevice> found;
  if (call.device.empty()) {
    for (const std::string& path : v4l2::device_nodes()) found.push_back(v4l2::describe_device(kernel, path));
  } else {
    found.push_back(v4l2::describe_device(kernel, call.device));
    if (!found.back().problem.empty()) throw std::runtime_error(found.back().problem);
  }
  if (call.json) {
    Json json = Json::array();
    for (const FoundDevice& device : found) json.push_back(json_of(device));
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
    return 0;
  }
  for (const FoundDevice& device : found) print_table(device);
  if (found.empty()) fmt::print("no cameras: there is no /dev/video0, nor any other of these nodes\n");
  return 0;
}

}  // namespace

void register_devices(CLI::App& app, int& status) {
  auto call = std::make_shared<DevicesCall>();
  CLI::App& command = *app.add_subcommand("devices", "List the cameras: formats, sizes, rates, controls");
  command.footer("Example: pavo devices --json");
  command.add_option("DEVICE", call->device, "one camera, such as /dev/video0; default: all");
  command.add_flag("--json", call->json, "as JSON");
  command.callback([call, &status] { status = devices(*call); });
}

}  // namespace pavo
