// The message of what a call throws.
#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace pavo::test {

/// The message of the std::runtime_error that `call` throws; it must be one line.
template <typename Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << "more than one line: " << message;
    return message;
  }
  ADD_FAILURE() << "expected an error";
  return {};
}

}  // namespace pavo::test
