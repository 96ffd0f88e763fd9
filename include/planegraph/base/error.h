#pragma once

#include <stdexcept>
#include <string>

namespace planegraph {

/// Input that cannot be read or is not valid, or an output that cannot be written (exit code 2).
/// what() is `FILE:PLACE: REASON`, where PLACE is a line, `byte N`, or empty.
class InputError : public std::runtime_error {
 public:
  InputError(std::string file, std::string place, std::string reason);
  static InputError AtLine(const std::string& file, std::size_t line, const std::string& reason);
  static InputError AtByte(const std::string& file, std::size_t byte, const std::string& reason);
  static InputError InFile(const std::string& file, const std::string& reason);

  const std::string& file() const { return file_; }
  const std::string& place() const { return place_; }
  const std::string& reason() const { return reason_; }

 private:
  std::string file_, place_, reason_;
};

/// Wrong usage: an unknown name, contradictory options (exit code 1).
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// It ran, and there is no result to rely on (exit code 3).
class NoResultError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace planegraph
