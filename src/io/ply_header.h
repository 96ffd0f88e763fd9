#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/point_columns.h"

namespace planegraph {

/// One property of a PLY element. A list has a count of `count_type` before its values of `type`.
struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  bool is_list = false;
  ScalarType count_type = ScalarType::kUint8;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool HasLists() const;
  /// Bytes of one binary record; the lists left out.
  std::size_t FixedBytes() const;
};

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::optional<Eigen::Vector3d> offset, viewpoint;  // from our own comments
  std::size_t body = 0;                              ///< first byte behind the header
  std::size_t lines = 0;                             ///< lines of the header
};

/// Throws InputError with the line.
PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& file);

/// The header at the stream's place, if it is that of a PLY and short (16 kB); the stream then
/// stands somewhere behind it. Throws as ParsePlyHeader.
std::optional<PlyHeader> ReadShortPlyHeader(std::istream* stream, const std::string& file);

}  // namespace planegraph
