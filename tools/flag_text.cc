#include "tools/flag_text.h"

#include <charconv>
#include <cstdlib>

namespace planegraph::tools {
namespace {

// gflags writes all 17 digits of a double: 0.050000000000000003.
std::string Shortest(const std::string& number) {
  char text[64];
  const double value = std::strtod(number.c_str(), nullptr);
  return {text, std::to_chars(text, text + sizeof(text), value).ptr};
}

}  // namespace

std::string FlagText(const std::string& type, const std::string& value) {
  return type == "double" ? Shortest(value) : value;
}

}  // namespace planegraph::tools
