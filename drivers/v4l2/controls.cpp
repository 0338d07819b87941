#include "drivers/v4l2/controls.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <optional>

namespace pavo::v4l2 {
namespace {

// "Exposure Time, Absolute" is exposure_time_absolute, as in v4l2-ctl.
std::string name_of(std::string_view title) {
  std::string name;
  for (const char c : title) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

template <class Character, std::size_t N>
std::string text_of(const Character (&field)[N]) {
  std::string text;
  for (std::size_t i = 0; i < N && field[i] != 0; ++i)
    text += field[i] >= ' ' && field[i] <= '~' ? static_cast<char>(field[i]) : '?';
  return text;
}

ControlKind kind_of(std::uint32_t type) {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_INTEGER64:
    case V4L2_CTRL_TYPE_BITMASK:
      return ControlKind::whole_number;
    case V4L2_CTRL_TYPE_BOOLEAN:
      return ControlKind::yes_no;
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
      return ControlKind::menu;
    case V4L2_CTRL_TYPE_BUTTON:
      return ControlKind::button;
    default:
      return ControlKind::other;
  }
}

std::vector<std::pair<std::int64_t, std::string>> choices_of(const Device& device, const Control& control,
                                                             bool of_numbers) {
  constexpr std::int64_t kMost = 256;
  std::vector<std::pair<std::int64_t, std::string>> choices;
  for (std::int64_t i = control.minimum; i <= control.maximum && i < control.minimum + kMost; ++i) {
    v4l2_querymenu item{};
    item.id = control.id;
    item.index = static_cast<std::uint32_t>(i);
    if (device.ioctl(VIDIOC_QUERYMENU, &item) < 0) continue;  // menus have holes
    choices.emplace_back(i, of_numbers ? std::to_string(item.value) : text_of(item.name));
  }
  return choices;
}

// Through the extended call, which every type goes through; drivers of old know the plain one only.
std::optional<std::int64_t> value_of(const Device& device, const Control& control, std::uint32_t type) {
  v4l2_ext_control value{};
  value.id = control.id;
  v4l2_ext_controls all{};
  all.which = V4L2_CTRL_WHICH_CUR_VAL;
  all.count = 1;
  all.controls = &value;
  const auto of_32_bits = [&](std::int32_t v) {
    return type == V4L2_CTRL_TYPE_BITMASK ? std::int64_t{static_cast<std::uint32_t>(v)} : v;
  };
  if (device.ioctl(VIDIOC_G_EXT_CTRLS, &all) >= 0)
    return type == V4L2_CTRL_TYPE_INTEGER64 ? std::int64_t{value.value64} : of_32_bits(value.value);
  v4l2_control plain{.id = control.id, .value = 0};
  if (device.ioctl(VIDIOC_G_CTRL, &plain) >= 0) return of_32_bits(plain.value);
  return std::nullopt;
}

Control control_of(const Device& device, const v4l2_query_ext_ctrl& query) {
  Control control{.id = query.id,
                  .name = name_of(text_of(query.name)),
                  .title = text_of(query.name),
                  .kind = kind_of(query.type),
                  .minimum = query.minimum,
                  .maximum = query.maximum,
                  .step = static_cast<std::int64_t>(query.step),
                  .fallback = query.default_value,
                  .read_only = (query.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0,
                  .inactive = (query.flags & (V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_GRABBED)) != 0};
  if (control.kind == ControlKind::menu)
    control.choices = choices_of(device, control, query.type == V4L2_CTRL_TYPE_INTEGER_MENU);
  if (control.kind != ControlKind::button && control.kind != ControlKind::other &&
      !(query.flags & V4L2_CTRL_FLAG_WRITE_ONLY))
    control.value = value_of(device, control, query.type).value_or(query.default_value);
  return control;
}

std::optional<std::int64_t> number_of(std::string_view text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string what_it_may_be(const Control& control) {
  switch (control.kind) {
    case ControlKind::yes_no:
      return "true or false";
    case ControlKind::button:
      return "1";
    case ControlKind::menu: {
      std::string all;
      for (const auto& [number, name] : control.choices)
        all += (all.empty() ? "" : ", ") + std::to_string(number) + " (" + name + ")";
      return "one of " + all;
    }
    default:
      return "a whole number from " + std::to_string(control.minimum) + " to " + std::to_string(control.maximum) +
             (control.step > 1 ? " in steps of " + std::to_string(control.step) : "");
  }
}

std::optional<std::int64_t> value_meant(const Control& control, const std::string& text) {
  if (control.kind == ControlKind::yes_no && (text == "true" || text == "false")) return text == "true" ? 1 : 0;
  if (control.kind == ControlKind::menu)
    for (const auto& [number, name] : control.choices)
      if (text == name || text == name_of(name)) return number;
  const std::optional<std::int64_t> number = number_of(text);
  if (!number || control.kind == ControlKind::other) return std::nullopt;
  if (control.kind == ControlKind::menu)
    return std::any_of(control.choices.begin(), control.choices.end(), [&](auto& c) { return c.first == *number; })
               ? number
               : std::nullopt;
  if (control.kind != ControlKind::button && (*number < control.minimum || *number > control.maximum))
    return std::nullopt;
  return number;
}

int set(const Device& device, const Control& control, std::int64_t value) {
  v4l2_query_ext_ctrl query{};
  query.id = control.id;
  const bool is_64_bits = device.ioctl(VIDIOC_QUERY_EXT_CTRL, &query) >= 0 && query.type == V4L2_CTRL_TYPE_INTEGER64;
  v4l2_ext_control one{};
  one.id = control.id;
  if (is_64_bits)
    one.value64 = value;
  else
    one.value = static_cast<std::int32_t>(value);
  v4l2_ext_controls all{};
  all.which = V4L2_CTRL_WHICH_CUR_VAL;
  all.count = 1;
  all.controls = &one;
  const int result = device.ioctl(VIDIOC_S_EXT_CTRLS, &all);
  if (result != -ENOTTY) return result;
  v4l2_control plain{.id = control.id, .value = static_cast<std::int32_t>(value)};
  return device.ioctl(VIDIOC_S_CTRL, &plain);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.remove_suffix(1);
  return text;
}

}  // namespace

std::vector<Control> controls_of(const Device& device) {
  constexpr int kMost = 1024;
  std::vector<Control> controls;
  v4l2_query_ext_ctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (int n = 0; n < kMost && device.ioctl(VIDIOC_QUERY_EXT_CTRL, &query) >= 0; ++n) {
    if (query.type != V4L2_CTRL_TYPE_CTRL_CLASS && !(query.flags & V4L2_CTRL_FLAG_DISABLED))
      controls.push_back(control_of(device, query));
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return controls;
}

std::vector<ControlValue> parse_controls(std::string_view text) {
  std::vector<ControlValue> values;
  while (!trimmed(text).empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view one = text.substr(0, comma);
    text = comma == std::string_view::npos ? "" : text.substr(comma + 1);
    const std::size_t equals = one.find('=');
    const std::string_view name = trimmed(one.substr(0, equals));
    const std::string_view value = equals == std::string_view::npos ? "" : trimmed(one.substr(equals + 1));
    if (name.empty() || value.empty())
      throw std::runtime_error("controls: '" + std::string(trimmed(one)) +
                               "' is none; expected NAME=VALUE, as in \"auto_exposure=1, gain=20\"");
    values.push_back({std::string(name), std::string(value)});
  }
  return values;
}

void set_controls(const Device& device, const std::vector<ControlValue>& values) {
  if (values.empty()) return;
  const std::vector<Control> controls = controls_of(device);
  for (const ControlValue& wanted : values) {
    const std::string what = device.path() + ": control " + wanted.name;
    const auto control =
        std::find_if(controls.begin(), controls.end(), [&](const Control& c) { return c.name == wanted.name; });
    if (control == controls.end())
      throw DeviceError(what + ": '" + device.name().card + "' has none of this name; `pavo devices` lists them");
    if (control->read_only) throw DeviceError(what + " can only be read");
    const std::optional<std::int64_t> value = value_meant(*control, wanted.value);
    if (!value) throw DeviceError(what + " must be " + what_it_may_be(*control) + ", not '" + wanted.value + "'");
    const int result = set(device, *control, *value);
    if (result < 0)
      throw DeviceError(
          what + " cannot be set to " + wanted.value + ": " + reason(result) +
              (control->inactive ? "; it has no effect while an automatic one is on: turn that off before" : ""),
          -result);
  }
}

}  // namespace pavo::v4l2
