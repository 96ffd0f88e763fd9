#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace planegraph {

static_assert(std::endian::native == std::endian::little, "packed arrays are little-endian");

/// Base64 (RFC 4648, with padding).
std::string EncodeBase64(std::string_view bytes);
/// Nothing where the text is not valid base64.
std::optional<std::string> DecodeBase64(std::string_view text);

/// Numbers as their little-endian bytes in base64.
template <typename T>
std::string PackArray(const std::vector<T>& values) {
  static_assert(std::is_arithmetic_v<T>);
  return EncodeBase64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

template <typename T>
std::optional<std::vector<T>> UnpackArray(std::string_view text) {
  static_assert(std::is_arithmetic_v<T>);
  const std::optional<std::string> bytes = DecodeBase64(text);
  if (!bytes || bytes->size() % sizeof(T) != 0) return {};
  std::vector<T> values(bytes->size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

/// Zeros and ones as bits, the first in the lowest bit of the first byte.
std::string PackBits(const std::vector<std::uint8_t>& flags);
/// Nothing unless the text holds exactly the bytes for `count` bits.
std::optional<std::vector<std::uint8_t>> UnpackBits(std::string_view text, std::size_t count);

}  // namespace planegraph
