// KITTI's calibration files: lines of "key: numbers".
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "types/pose.h"

namespace pavo {

class KittiFile {
 public:
  /// Throws std::runtime_error (one line) where a line has no key, or a key comes twice.
  KittiFile(std::string_view text, std::string name);

  const std::string& name() const { return name_; }
  bool has(const std::string& key) const { return entries_.contains(key); }
  int line(const std::string& key) const;

  /// The `count` finite numbers of the entry. Throws where it is missing, or has others.
  std::vector<double> numbers(const std::string& key, std::size_t count) const;

  /// The rigid motion of a rotation entry (9 numbers, row-major) and a translation entry (3 numbers, metres).
  SE3 motion(const std::string& rotation_key, const std::string& translation_key) const;
  Eigen::Matrix3d rotation(const std::string& key) const;

  /// Is this text KITTI's: does a line start with P0: ... P3:, or with P_rect_0n:, K_0n:?
  static bool recognises(std::string_view text);

 private:
  struct Entry {
    int line = 0;
    std::string values;
  };
  std::string name_;
  std::map<std::string, Entry> entries_;
};

/// The rotation nearest to `m` (in the Frobenius norm); throws where `m` is farther from it than the rounding of a text
/// file explains. `what` begins the message.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m, const std::string& file, int line, const std::string& what);

}  // namespace pavo
