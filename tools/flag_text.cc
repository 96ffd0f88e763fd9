#include "tools/flag_text.h"

#include <cstdio>
#include <cstdlib>

namespace planegraph::tools {
namespace {

// gflags writes all 17 digits of a double: 0.050000000000000003.
std::string Shortest(const std::string& number) {
  const double value = std::strtod(number.c_str(), nullptr);
  char text[64];
  for (int digits = 1; digits <= 17; ++digits) {
    std::snprintf(text, sizeof(text), "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) return text;
  }
  return number;
}

}  // namespace

std::string FlagText(const std::string& type, const std::string& value) {
  return type == "double" ? Shortest(value) : value;
}

}  // namespace planegraph::tools
