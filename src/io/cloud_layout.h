#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/cloud_builder.h"
#include "io/pcd_header.h"
#include "io/ply_header.h"
#include "io/point_columns.h"

namespace planegraph {

/// Where the points of a file lie whose records, or lines, follow each other from one byte on.
struct CloudLayout {
  struct Field {
    Role role;
    ScalarType type;
    std::size_t place;  ///< bytes from the start of the record
  };
  std::uint64_t count = 0;  ///< points
  std::size_t body = 0;     ///< first byte of the points
  bool is_text = false;
  // Binary:
  std::vector<Field> fields;  ///< those with a role
  std::size_t stride = 0;     ///< bytes of a record
  bool swap_bytes = false;
  // Text:
  TextColumns text;
  std::size_t words = 0;  ///< of a line
  std::size_t lines = 0;  ///< before the body
  std::string lines_are;  ///< what messages call them
  std::optional<Eigen::Vector3d> offset;
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();

  /// `count` binary records that begin at `first`.
  PointColumns ColumnsAt(const char* first, std::size_t count) const;
};

/// The columns of a line of text.
TextColumns TextColumnsOf(const PlyElement& vertex, const PlyHeader& header);
TextColumns TextColumnsOf(const PcdHeader& header, const std::vector<Role>& roles);
/// One role for each property or field; lists, and fields of several values, have none. Throws
/// InputError where there is no x, y, z.
std::vector<Role> RolesOf(const PlyElement& vertex);
std::vector<Role> RolesOf(const PcdHeader& header, const std::string& file);
/// Throws InputError where there are none with x, y, z.
const PlyElement& FindVertices(const PlyHeader& header, const std::string& file);

/// Nothing where the points do not lie so: compressed, behind elements of text or with lists, or
/// with lists themselves. `bytes` is the file's start, `size` its whole length. Throws InputError,
/// also where the file is too short for its points.
std::optional<CloudLayout> LayoutOf(const PlyHeader& header, std::uint64_t size,
                                    const std::string& file);
std::optional<CloudLayout> LayoutOf(const PcdHeader& header, std::uint64_t size,
                                    const std::string& file);

}  // namespace planegraph
