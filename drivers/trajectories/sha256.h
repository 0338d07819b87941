// SHA-256 (FIPS 180-4) of files and of what is written, as lower-case hexadecimal.
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace pavo {

/// Takes bytes in any pieces. One thread at a time; update() neither blocks nor allocates. Movable. Throws
/// std::runtime_error where the cryptographic library refuses.
class Sha256 {
 public:
  Sha256();
  void update(std::string_view bytes);
  /// The digest of everything so far, 64 hexadecimal digits; update() may go on after it.
  std::string hex() const;

 private:
  struct Free {
    void operator()(void* context) const;
  };
  std::unique_ptr<void, Free> context_;
};

/// Of a file's bytes. Throws std::runtime_error, with the path and the reason, where it cannot be read.
std::string sha256_of_file(const std::string& path);

}  // namespace pavo
