#include <optional>

#include "io/cloud_formats.h"
#include "io/file_bytes.h"
#include "io/ply_header.h"

namespace planegraph {
namespace {

// Byte `source` of a binary record; nothing where there is none.
std::optional<std::size_t> PlaceOfSource(const PlyHeader& header) {
  if (header.encoding == PlyEncoding::kAscii) return std::nullopt;
  const PlyElement& vertex = header.elements.front();
  if (vertex.name != "vertex" || vertex.HasLists()) return std::nullopt;
  std::size_t place = 0;
  for (const PlyProperty& property : vertex.properties) {
    if (property.name == "source" && SizeOf(property.type) == 1) return place;
    place += SizeOf(property.type);
  }
  return std::nullopt;
}

// Sorts the points by the bytes at `source`, one in each record.
MergedMap Split(const Cloud& cloud, const char* source, std::size_t record) {
  std::vector<std::uint32_t> laser, vision;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const bool is_vision = source[i * record] == static_cast<char>(PointSource::kVision);
    (is_vision ? vision : laser).push_back(i);
  }
  return {Select(cloud, laser), Select(cloud, vision)};
}

}  // namespace

MergedMap ParseMapPly(std::string_view bytes, const std::string& file) {
  Cloud cloud = ParsePly(bytes, file);
  const PlyHeader header = ParsePlyHeader(bytes, file);
  const auto place = PlaceOfSource(header);
  // Points that are not finite were dropped: then nobody knows which record is whose.
  if (!place || cloud.size() == 0 || cloud.size() != header.elements.front().count) {
    return {std::move(cloud), {}};
  }
  return Split(cloud, bytes.data() + header.body + *place, header.elements.front().FixedBytes());
}

MergedMap ReadMapPly(const std::string& path) {
  const FileBytes file(path);
  return ParseMapPly(file.view(), path);
}

}  // namespace planegraph
