#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include "io/ply_header.h"
#include "io/point_columns.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

constexpr std::size_t kPositionsAtOnce = 16384;

// The header of a file in the form that WriteCloud and MapPlyWriter give it: vertices first, binary
// records of one size, floats beside an offset, nothing missing at the end.
std::optional<PlyHeader> PlainHeader(std::ifstream* stream, const std::string& path) {
  const auto found = ReadShortPlyHeader(stream, path);
  if (!found) return {};
  const PlyHeader& header = *found;
  if (header.encoding != PlyEncoding::kLittleEndian || !header.offset) return {};
  if (header.elements.empty()) return {};
  const PlyElement& vertex = header.elements.front();
  if (vertex.name != "vertex" || vertex.HasLists() || vertex.count == 0) return {};
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size < header.body || vertex.properties.empty()) return {};
  if (vertex.count > (size - header.body) / vertex.FixedBytes()) return {};
  return header;
}

// The columns x, y, z of records that begin at `first`; fewer than three where they are no floats.
std::vector<Column> PositionColumns(const PlyElement& vertex, const char* first) {
  std::vector<Role> roles;
  for (const PlyProperty& property : vertex.properties) roles.push_back(RoleOfName(property.name));
  SkipRepeatedRoles(&roles);
  std::vector<Column> columns;
  const std::size_t stride = vertex.FixedBytes();
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const ScalarType type = vertex.properties[i].type;
    if (roles[i] <= Role::kZ && type == ScalarType::kFloat32) {
      columns.push_back({roles[i], type, first, stride});
    }
    first += SizeOf(type);
  }
  return columns;
}

// Nothing where the file has another form or is damaged.
std::optional<Cloud> ReadByBlocks(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};  // what a pipe gave is gone
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return {};
  const auto header = PlainHeader(&stream, path);
  if (!header) return {};
  const PlyElement& vertex = header->elements.front();
  std::vector<char> block(kPositionsAtOnce * vertex.FixedBytes());
  PointColumns columns;
  columns.columns = PositionColumns(vertex, block.data());
  columns.offset = header->offset;
  if (columns.columns.size() != 3) return {};
  stream.seekg(static_cast<std::streamoff>(header->body));
  Cloud cloud;
  cloud.offset = *header->offset;
  cloud.viewpoint = header->viewpoint.value_or(Eigen::Vector3d::Zero());
  cloud.points.reserve(vertex.count);
  for (std::uint64_t have = 0; have < vertex.count; have += columns.count) {
    columns.count = std::min<std::uint64_t>(kPositionsAtOnce, vertex.count - have);
    const auto bytes = static_cast<std::streamsize>(columns.count * vertex.FixedBytes());
    if (!stream.read(block.data(), bytes)) return {};
    const Cloud part = AssembleCloud(columns);
    cloud.points.insert(cloud.points.end(), part.points.begin(), part.points.end());
  }
  return cloud;
}

}  // namespace

Cloud ReadPositions(const std::string& path, const std::string& format) {
  if (format == "ply") {
    auto cloud = ReadByBlocks(path);
    if (cloud && cloud->size() > 0) return std::move(*cloud);
  }
  // Every other file, and what is wrong with one.
  Cloud cloud = ReadCloud(path, format);
  cloud.normals.clear();
  cloud.colors.clear();
  cloud.intensities.clear();
  return cloud;
}

}  // namespace planegraph
