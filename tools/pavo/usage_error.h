// A wrong call that only the command itself can see.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace pavo {

/// Ends the command with status 2, as a misspelt option does.
class UsageError : public CLI::ParseError {
 public:
  explicit UsageError(const std::string& message)
      : CLI::ParseError("UsageError", message, CLI::ExitCodes::ValidationError) {}
};

}  // namespace pavo
