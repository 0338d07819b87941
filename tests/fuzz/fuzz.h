// What a fuzzer checks of every parser: it takes the text, or throws one line that begins with the file's name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace pavo::fuzz {

/// The name that the fuzzers give to their texts.
inline const std::string kName = "FILE";

/// Ends the process, as the fuzzer wants it, where a promise is broken.
inline void require(bool kept, const char* promise) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", promise);
  std::abort();
}

/// Calls `parse`, and `check` with its result. A std::runtime_error of one line is an answer too; anything else is not.
template <typename Parse, typename Check>
void try_parse(Parse parse, Check check) {
  try {
    check(parse());
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    require(message.starts_with(kName + ":"), "an error begins with the file's name");
    require(message.find('\n') == std::string::npos && message.find('\r') == std::string::npos, "an error is one line");
    require(message.size() < 1000, "an error is short");
  }
}

}  // namespace pavo::fuzz
