#include "drivers/trajectories/sha256.h"

#include <openssl/evp.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace pavo {
namespace {

EVP_MD_CTX* evp(void* context) {
  return static_cast<EVP_MD_CTX*>(context);
}

void check(int success) {
  if (success != 1) throw std::runtime_error("SHA-256 is refused by OpenSSL: check its configuration (openssl.cnf)");
}

}  // namespace

void Sha256::Free::operator()(void* context) const {
  EVP_MD_CTX_free(evp(context));
}

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  check(context_ ? 1 : 0);
  check(EVP_DigestInit_ex(evp(context_.get()), EVP_sha256(), nullptr));
}

void Sha256::update(std::string_view bytes) {
  check(EVP_DigestUpdate(evp(context_.get()), bytes.data(), bytes.size()));
}

std::string Sha256::hex() const {
  const std::unique_ptr<void, Free> copy(EVP_MD_CTX_new());
  check(copy ? 1 : 0);
  check(EVP_MD_CTX_copy_ex(evp(copy.get()), evp(context_.get())));
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  check(EVP_DigestFinal_ex(evp(copy.get()), digest.data(), &size));
  std::string text;
  for (unsigned i = 0; i < size; ++i) {
    text += "0123456789abcdef"[digest[i] >> 4];
    text += "0123456789abcdef"[digest[i] & 15];
  }
  return text;
}

std::string sha256_of_file(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be read: " + std::generic_category().message(errno));
  Sha256 sum;
  std::array<char, 65536> block{};
  while (file.read(block.data(), block.size()) || file.gcount() > 0)
    sum.update({block.data(), static_cast<std::size_t>(file.gcount())});
  if (file.bad()) throw std::runtime_error(path + ": cannot be read: " + std::generic_category().message(errno));
  return sum.hex();
}

}  // namespace pavo
