#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "planegraph/base/error.h"

namespace planegraph {

/// Gives the bytes to a reader. InputError is a good answer; anything else that is thrown, and what
/// the sanitizers find, ends the fuzzer.
template <typename Reader>
int FuzzReader(const std::uint8_t* data, std::size_t size, const Reader& reader) {
  try {
    reader(std::string_view(reinterpret_cast<const char*>(data), size));
  } catch (const InputError&) {
  }
  return 0;
}

/// A reader's promise about clouds: attributes are absent or complete, and all points are finite.
template <typename Cloud>
void CheckCloud(const Cloud& cloud) {
  const auto fits = [&](std::size_t size) { return size == 0 || size == cloud.size(); };
  bool good = fits(cloud.normals.size()) && fits(cloud.colors.size()) &&
              fits(cloud.intensities.size()) && cloud.offset.allFinite();
  for (const auto& point : cloud.points) good = good && point.allFinite();
  if (!good) __builtin_trap();
}

}  // namespace planegraph
