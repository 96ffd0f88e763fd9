#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <string>
#include <vector>

namespace planegraph {

/// What the tests read of a PNG with a palette and no interlacing; a failure where it is not one.
struct DecodedPng {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
  std::string palette, opacities;
};

inline std::uint32_t ReadBigEndian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

inline void UnpackRows(const std::string& packed, DecodedPng* png) {
  std::string rows((png->width + 1) * png->height, '\0');
  uLongf size = rows.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(rows.data()), &size,
                       reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
            Z_OK);
  ASSERT_EQ(size, rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i % (png->width + 1) == 0) {
      ASSERT_EQ(rows[i], 0) << "only filter 0 is read here";
    } else {
      png->pixels.push_back(static_cast<std::uint8_t>(rows[i]));
    }
  }
}

inline void DecodePng(const std::string& bytes, DecodedPng* png) {
  ASSERT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  std::string packed, type;
  for (std::size_t at = 8; at < bytes.size();) {
    const std::size_t length = ReadBigEndian(bytes, at);
    ASSERT_LE(at + 12 + length, bytes.size());
    type = bytes.substr(at + 4, 4);
    const std::string data = bytes.substr(at + 8, length);
    const std::string body = type + data;
    ASSERT_EQ(crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())),
              ReadBigEndian(bytes, at + 8 + length));
    if (type == "IHDR") {
      png->width = ReadBigEndian(data, 0);
      png->height = ReadBigEndian(data, 4);
      ASSERT_EQ(data.substr(8), (std::string{8, 3, 0, 0, 0}));
    }
    if (type == "PLTE") png->palette = data;
    if (type == "tRNS") png->opacities = data;
    if (type == "IDAT") packed += data;
    at += 12 + length;
  }
  ASSERT_EQ(type, "IEND");
  UnpackRows(packed, png);
}

inline std::string DecodeBase64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return bytes;
}

}  // namespace planegraph
