#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace planegraph {

/// Red, green, blue, opacity.
using Rgba = std::array<std::uint8_t, 4>;

/// A picture of palette indices, row by row from the top.
struct IndexedImage {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

/// The picture as the bytes of a PNG file with at most 256 colours (ISO/IEC 15948).
std::string EncodePng(const IndexedImage& image, const std::vector<Rgba>& palette);

/// Compressed in zlib's format (RFC 1950), levels 1 (fast) to 9.
std::string Deflate(const std::string& bytes, int level);

/// RFC 4648, with padding.
std::string Base64(std::string_view bytes);

}  // namespace planegraph
