#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/point_columns.h"

namespace planegraph {

struct PcdField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;  ///< values of this field per point

  std::size_t Bytes() const { return count * SizeOf(type); }
};

enum class PcdData { kAscii, kBinary, kCompressed };

struct PcdHeader {
  std::vector<PcdField> fields;
  std::uint64_t points = 0;
  PcdData data = PcdData::kAscii;
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> offset;  // from our own comment
  std::size_t body = 0;                   ///< first byte behind the header
  std::size_t lines = 0;                  ///< lines of the header

  std::size_t PointBytes() const;
  std::size_t PointValues() const;  ///< words of a line of text
};

/// Throws InputError with the line.
PcdHeader ParsePcdHeader(std::string_view bytes, const std::string& file);

}  // namespace planegraph
