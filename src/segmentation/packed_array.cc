#include "segmentation/packed_array.h"

#include <algorithm>
#include <array>

namespace planegraph {
namespace {

constexpr std::string_view kDigits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::array<int, 256> MakeValues() {
  std::array<int, 256> values;
  values.fill(-1);
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    values[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
  }
  return values;
}

}  // namespace

std::string EncodeBase64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0u;
  };
  char* to = text.data();
  for (std::size_t i = 0; i < bytes.size(); i += 3, to += 4) {
    const std::uint32_t group = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    to[0] = kDigits[group >> 18], to[1] = kDigits[group >> 12 & 63];
    if (i + 1 < bytes.size()) to[2] = kDigits[group >> 6 & 63];
    if (i + 2 < bytes.size()) to[3] = kDigits[group & 63];
  }
  return text;
}

std::optional<std::string> DecodeBase64(std::string_view text) {
  static const std::array<int, 256> kValues = MakeValues();
  if (text.size() % 4 != 0) return {};
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  for (std::size_t i = 0; i < text.size(); i += 4) {
    const bool last = i + 4 == text.size();
    const std::size_t padding = !last || text[i + 3] != '=' ? 0 : text[i + 2] != '=' ? 1 : 2;
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const int value = k < 4 - padding ? kValues[static_cast<unsigned char>(text[i + k])] : 0;
      if (value < 0) return {};
      group = group << 6 | static_cast<std::uint32_t>(value);
    }
    for (std::size_t k = 0; k < 3 - padding; ++k) {
      bytes.push_back(static_cast<char>(group >> (16 - 8 * k) & 255));
    }
  }
  return bytes;
}

std::string PackBits(const std::vector<std::uint8_t>& flags) {
  std::string bytes((flags.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i]) bytes[i / 8] = static_cast<char>(bytes[i / 8] | 1 << i % 8);
  }
  return EncodeBase64(bytes);
}

std::optional<std::vector<std::uint8_t>> UnpackBits(std::string_view text, std::size_t count) {
  const std::optional<std::string> bytes = DecodeBase64(text);
  if (!bytes || bytes->size() != (count + 7) / 8) return {};
  std::vector<std::uint8_t> flags(count);
  for (std::size_t i = 0; i < count; ++i) flags[i] = (*bytes)[i / 8] >> i % 8 & 1;
  return flags;
}

}  // namespace planegraph
