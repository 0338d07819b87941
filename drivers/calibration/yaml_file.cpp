#include "drivers/calibration/yaml_file.h"

#include <algorithm>
#include <set>

#include "drivers/calibration/text.h"

namespace pavo {
namespace {

constexpr std::size_t kMostNumbers = 1024;

int line_of(const YAML::Mark& mark) {
  return mark.is_null() ? 0 : mark.line + 1;
}

/// OpenCV writes "%YAML:1.0", which is no YAML directive: the line is blanked, so that the others keep their numbers.
std::string without_directives(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::string result(text);
  for (std::size_t begin = 0; begin < result.size();) {
    const std::size_t end = std::min(result.find('\n', begin), result.size());
    if (result[begin] == '%') std::fill(result.begin() + begin, result.begin() + end, ' ');
    if (result.compare(begin, 3, "---") == 0) break;  // directives stand before the document
    begin = end + 1;
  }
  return result;
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

double scalar(const YAML::Node& node, const Place& place) {
  const auto value = node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt;
  if (!value) {
    fail_at(place.file, line_of(node.Mark()),
            place.key + " has " + (node.IsScalar() ? quoted(node.Scalar()) : "something else") +
                ": expected finite numbers only");
  }
  return *value;
}

void append_numbers(const YAML::Node& list, const Place& place, std::vector<double>& values) {
  for (const YAML::Node& item : list) {
    if (item.IsSequence()) {
      for (const YAML::Node& inner : item) values.push_back(scalar(inner, place));
    } else {
      values.push_back(scalar(item, place));
    }
    if (values.size() > kMostNumbers) fail_at(place.file, place.line, place.key + " has too many numbers");
  }
}

}  // namespace

YamlFile::YamlFile(std::string_view text, std::string name) : name_(std::move(name)) {
  try {
    root_ = YAML::Load(without_directives(text));
  } catch (const YAML::Exception& error) {
    fail_at(
        name_, line_of(error.mark),
        "is no calibration and no YAML (" + first_line(error.msg) + "): expected KITTI, EuRoC, ROS or OpenCV format");
  }
  if (!root_.IsMap()) {
    fail_at(name_, 0, "is no camera calibration: expected lines 'P0: ...' (KITTI), or YAML as of EuRoC, ROS or OpenCV");
  }
  std::set<std::string> seen;
  for (const auto& entry : root_) {
    if (entry.first.IsScalar() && !seen.insert(entry.first.Scalar()).second) {
      fail_at(name_, line_of(entry.first.Mark()),
              quoted(entry.first.Scalar()) + " comes a second time: keep one of the two");
    }
  }
}

std::optional<std::string> YamlFile::find(std::initializer_list<const char*> spellings) const {
  for (const std::string spelling : spellings) {
    if (std::as_const(root_)[spelling]) return spelling;
  }
  return std::nullopt;
}

std::string YamlFile::need(std::initializer_list<const char*> spellings, const std::string& expected) const {
  if (const auto key = find(spellings)) return *key;
  fail_at(name_, 0, "has no " + std::string(*spellings.begin()) + ": expected " + expected);
}

Place YamlFile::place(const std::string& key) const {
  const YAML::Node node = std::as_const(root_)[key];
  return {name_, node ? line_of(node.Mark()) : 0, key};
}

std::vector<double> YamlFile::numbers(const std::string& key) const {
  const Place where = place(key);
  const YAML::Node node = std::as_const(root_)[key];
  std::vector<double> values;
  if (node.IsSequence()) {
    append_numbers(node, where, values);
    return values;
  }
  const YAML::Node data = node.IsMap() ? std::as_const(node)["data"] : YAML::Node(YAML::NodeType::Undefined);
  if (!node.IsMap() || !data.IsDefined() || !data.IsSequence()) {
    fail_at(name_, where.line, key + " is no list of numbers: expected [a, b, ...], or rows, cols and data");
  }
  append_numbers(data, where, values);
  const YAML::Node rows = std::as_const(node)["rows"], columns = std::as_const(node)["cols"];
  if (rows.IsDefined() && columns.IsDefined() &&
      scalar(rows, where) * scalar(columns, where) != static_cast<double>(values.size())) {
    fail_at(name_, where.line,
            key + " has " + std::to_string(values.size()) + " numbers, which rows x cols does not say");
  }
  return values;
}

std::vector<double> YamlFile::numbers(const std::string& key, std::size_t count) const {
  std::vector<double> values = numbers(key);
  if (values.size() == count) return values;
  fail_at(name_, place(key).line,
          key + " has " + std::to_string(values.size()) + " numbers: expected " + std::to_string(count));
}

double YamlFile::number(const std::string& key) const {
  return scalar(std::as_const(root_)[key], place(key));
}

std::string YamlFile::text(const std::string& key) const {
  const YAML::Node node = std::as_const(root_)[key];
  if (node.IsScalar()) return node.Scalar();
  fail_at(name_, place(key).line, key + " is no word: expected a name");
}

}  // namespace pavo
