#include <cstring>

#include "io/cloud_formats.h"
#include "io/file_bytes.h"
#include "io/ply_header.h"
#include "planegraph/io/cloud_writer.h"
#include "planegraph/io/labelled_cloud.h"

namespace planegraph {
namespace {

// Where a property of that name and type lies in a record.
std::optional<std::size_t> PlaceOf(const PlyElement& vertex, const std::string& name,
                                   ScalarType type) {
  std::size_t place = 0;
  for (const PlyProperty& property : vertex.properties) {
    if (property.name == name && property.type == type) return place;
    place += SizeOf(property.type);
  }
  return {};
}

struct Layout {
  std::size_t x, y, z, plane;
  std::optional<std::size_t> scan, source;
};

std::optional<Layout> LayoutOf(const PlyHeader& header) {
  if (header.encoding != PlyEncoding::kLittleEndian || header.elements.empty()) return {};
  const PlyElement& vertex = header.elements.front();
  if (vertex.name != "vertex" || vertex.HasLists()) return {};
  const auto x = PlaceOf(vertex, "x", ScalarType::kFloat32);
  const auto y = PlaceOf(vertex, "y", ScalarType::kFloat32);
  const auto z = PlaceOf(vertex, "z", ScalarType::kFloat32);
  const auto plane = PlaceOf(vertex, "plane", ScalarType::kInt32);
  if (!x || !y || !z || !plane) return {};
  return Layout{*x,
                *y,
                *z,
                *plane,
                PlaceOf(vertex, "scan", ScalarType::kInt32),
                PlaceOf(vertex, "source", ScalarType::kUint8)};
}

template <typename T>
T Load(const char* record, std::size_t place) {
  T value;
  std::memcpy(&value, record + place, sizeof(T));
  return value;
}

void AddRecord(const char* record, const Layout& layout, LabelledCloud* out) {
  const Eigen::Vector3f point(Load<float>(record, layout.x), Load<float>(record, layout.y),
                              Load<float>(record, layout.z));
  if (!point.allFinite()) return;
  out->cloud.points.push_back(point);
  out->planes.push_back(Load<std::int32_t>(record, layout.plane));
  out->scans.push_back(layout.scan ? Load<std::int32_t>(record, *layout.scan) : 0);
  const bool vision = layout.source && Load<std::uint8_t>(record, *layout.source) ==
                                           static_cast<std::uint8_t>(PointSource::kVision);
  out->vision.push_back(vision ? 1 : 0);
}

}  // namespace

std::optional<LabelledCloud> ParseLabelledPly(std::string_view bytes, const std::string& file) {
  if (!bytes.starts_with("ply\n")) return {};
  const PlyHeader header = ParsePlyHeader(bytes, file);
  const auto layout = LayoutOf(header);
  if (!layout) return {};
  const PlyElement& vertex = header.elements.front();
  CheckRecordsFit(bytes, header.body, vertex.count, vertex.FixedBytes(), file);
  LabelledCloud result;
  if (header.offset) result.cloud.offset = *header.offset;
  const char* record = bytes.data() + header.body;
  for (std::uint64_t i = 0; i < vertex.count; ++i, record += vertex.FixedBytes()) {
    AddRecord(record, *layout, &result);
  }
  return result;
}

std::optional<LabelledCloud> ReadLabelledCloud(const std::string& path) {
  return ParseLabelledPly(FileBytes(path).view(), path);
}

}  // namespace planegraph
