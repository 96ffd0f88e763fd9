#include "planegraph/base/error.h"

#include <utility>

namespace planegraph {
namespace {

std::string Join(const std::string& file, const std::string& place, const std::string& reason) {
  return place.empty() ? file + ": " + reason : file + ":" + place + ": " + reason;
}

}  // namespace

InputError::InputError(std::string file, std::string place, std::string reason)
    : std::runtime_error(Join(file, place, reason)),
      file_(std::move(file)),
      place_(std::move(place)),
      reason_(std::move(reason)) {}

InputError InputError::AtLine(const std::string& file, std::size_t line,
                              const std::string& reason) {
  return InputError(file, std::to_string(line), reason);
}

InputError InputError::AtByte(const std::string& file, std::size_t byte,
                              const std::string& reason) {
  return InputError(file, "byte " + std::to_string(byte), reason);
}

InputError InputError::InFile(const std::string& file, const std::string& reason) {
  return InputError(file, "", reason);
}

}  // namespace planegraph
