#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "io/cloud_formats.h"
#include "io/ply_header.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/cloud_writer.h"

namespace planegraph {
namespace {

constexpr std::size_t kHeaderBytes = 16384;
constexpr std::size_t kBlockPoints = 16384;

// The fields that MapPlyWriter writes, in its order.
constexpr std::array<std::pair<const char*, ScalarType>, 9> kFields = {
    {{"x", ScalarType::kFloat32},
     {"y", ScalarType::kFloat32},
     {"z", ScalarType::kFloat32},
     {"red", ScalarType::kUint8},
     {"green", ScalarType::kUint8},
     {"blue", ScalarType::kUint8},
     {"source", ScalarType::kUint8},
     {"scan", ScalarType::kInt32},
     {"plane", ScalarType::kInt32}}};
constexpr std::size_t kRecordBytes = 24, kPlaceOfColour = 12, kPlaceOfSource = 15;

bool IsOurs(const PlyHeader& header) {
  if (header.encoding != PlyEncoding::kLittleEndian || header.elements.size() != 1) return false;
  const PlyElement& vertex = header.elements.front();
  return vertex.name == "vertex" && header.offset &&
         std::equal(vertex.properties.begin(), vertex.properties.end(), kFields.begin(),
                    kFields.end(), [](const PlyProperty& property, const auto& field) {
                      return !property.is_list && property.name == field.first &&
                             property.type == field.second;
                    });
}

void AddRecord(const char* record, MergedMap* map) {
  Eigen::Vector3f point;
  std::memcpy(point.data(), record, sizeof(float) * 3);
  if (!point.allFinite()) return;
  if (record[kPlaceOfSource] != static_cast<char>(PointSource::kVision)) {
    map->laser.points.push_back(point);
    return;
  }
  map->vision.points.push_back(point);
  std::memcpy(map->vision.colors.emplace_back().data(), record + kPlaceOfColour, 3);
}

}  // namespace

std::optional<MergedMap> ParseMapPly(std::istream* stream, const std::string& file) {
  std::string start(kHeaderBytes, '\0');
  stream->read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream->gcount()));
  stream->clear();
  if (!start.starts_with("ply\n") || start.find("\nend_header\n") == start.npos) return {};
  const PlyHeader header = ParsePlyHeader(start, file);
  if (!IsOurs(header)) return {};
  MergedMap map;
  map.laser.offset = map.vision.offset = *header.offset;
  stream->seekg(static_cast<std::streamoff>(header.body));
  std::vector<char> block(kBlockPoints * kRecordBytes);
  const std::uint64_t count = header.elements.front().count;
  for (std::uint64_t have = 0; have < count; have += kBlockPoints) {
    const std::size_t points = std::min<std::uint64_t>(kBlockPoints, count - have);
    if (!stream->read(block.data(), static_cast<std::streamsize>(points * kRecordBytes))) return {};
    for (std::size_t i = 0; i < points; ++i) AddRecord(&block[i * kRecordBytes], &map);
  }
  return map;
}

MergedMap ReadMapPly(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) {  // what a pipe gave would be gone
    std::ifstream stream(path, std::ios::binary);
    if (stream) {
      if (auto map = ParseMapPly(&stream, path)) return std::move(*map);
    }
  }
  // Every other file, and what is wrong with one.
  return {ReadPositions(path, "ply"), {}};
}

}  // namespace planegraph
