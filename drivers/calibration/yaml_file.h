// A YAML file with a map at its top, read with errors that name file, line and key.
#pragma once

#include <yaml-cpp/yaml.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/calibration/camera_check.h"

namespace pavo {

class YamlFile {
 public:
  /// Throws std::runtime_error (one line) where it is no YAML, no map, or has a key twice.
  YamlFile(std::string_view text, std::string name);

  const std::string& name() const { return name_; }

  /// The first of the spellings that the file has; nothing where it has none.
  std::optional<std::string> find(std::initializer_list<const char*> spellings) const;
  /// The same, but throws where there is none; `expected` says what belongs there.
  std::string need(std::initializer_list<const char*> spellings, const std::string& expected) const;

  Place place(const std::string& key) const;

  /// A list of finite numbers, a list of such lists, or a matrix (a map with rows, cols and data, which must agree).
  std::vector<double> numbers(const std::string& key) const;
  /// The same, of that length.
  std::vector<double> numbers(const std::string& key, std::size_t count) const;
  double number(const std::string& key) const;
  std::string text(const std::string& key) const;

 private:
  std::string name_;
  YAML::Node root_;
};

}  // namespace pavo
