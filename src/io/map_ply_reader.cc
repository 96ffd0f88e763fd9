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
constexpr std::size_t kRecordBytes = 24, kPlaceOfColour = 12, kPlaceOfSource = 15,
                      kPlaceOfScan = 16, kPlaceOfPlane = 20;

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

// The header of a file of ours, with the stream at the first record; nothing for any other.
std::optional<PlyHeader> OpenOurs(std::istream* stream, const std::string& file) {
  std::optional<PlyHeader> header = ReadShortPlyHeader(stream, file);
  if (!header || !IsOurs(*header)) return {};
  stream->seekg(static_cast<std::streamoff>(header->body));
  return header;
}

// Calls visit(first, count, records) for one block after the other; false where the file ends
// before.
template <typename Visit>
bool ForEachBlock(std::istream* stream, std::uint64_t count, const Visit& visit) {
  std::vector<char> block(kBlockPoints * kRecordBytes);
  for (std::uint64_t first = 0; first < count; first += kBlockPoints) {
    const std::size_t points = std::min<std::uint64_t>(kBlockPoints, count - first);
    if (!stream->read(block.data(), static_cast<std::streamsize>(points * kRecordBytes))) {
      return false;
    }
    visit(first, points, block.data());
  }
  return true;
}

MapPlyPoint ParseRecord(const char* record) {
  MapPlyPoint point;
  std::memcpy(point.position.data(), record, sizeof(float) * 3);
  std::memcpy(point.rgb.data(), record + kPlaceOfColour, 3);
  point.source = record[kPlaceOfSource] == static_cast<char>(PointSource::kVision)
                     ? PointSource::kVision
                     : PointSource::kLaser;
  std::memcpy(&point.scan, record + kPlaceOfScan, sizeof(point.scan));
  std::memcpy(&point.plane, record + kPlaceOfPlane, sizeof(point.plane));
  return point;
}

// How many records the rest of the stream has room for.
std::uint64_t RecordsLeft(std::istream* stream) {
  const std::istream::pos_type here = stream->tellg();
  stream->seekg(0, std::ios::end);
  const std::istream::off_type bytes = stream->tellg() - here;
  stream->seekg(here);
  return bytes > 0 ? static_cast<std::uint64_t>(bytes) / kRecordBytes : 0;
}

// The stretches of a file of which a sample has one point each.
class Stretches {
 public:
  Stretches(std::uint64_t count, std::uint64_t most)
      : count_(count), stretches_(std::min(count, most)) {}
  std::uint64_t size() const { return stretches_; }
  // The index of the point of stretch k: anywhere in it, so that no regular pattern of a scanner's
  // lines shows, and the same in every run.
  std::uint64_t Chosen(std::uint64_t k) const {
    const std::uint64_t begin = Begin(k), length = Begin(k + 1) - begin;
    std::uint64_t mixed = (k + 1) * 0x9e3779b97f4a7c15u;
    mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9u;
    return begin + (mixed >> 32) % length;
  }

 private:
  std::uint64_t Begin(std::uint64_t k) const {
    return static_cast<std::uint64_t>(static_cast<double>(k) * static_cast<double>(count_) /
                                      static_cast<double>(stretches_));
  }
  std::uint64_t count_, stretches_;
};

// Gathers the points of one source, which may be any number: every second one is let go whenever
// there are too many.
class Thinned {
 public:
  Thinned(std::size_t most, Cloud* cloud) : most_(most), cloud_(cloud) {}

  void Add(const Eigen::Vector3f& point, const char* colour) {
    if (seen_++ % stride_ != 0) return;
    cloud_->points.push_back(point);
    if (colour != nullptr) std::memcpy(cloud_->colors.emplace_back().data(), colour, 3);
    if (cloud_->size() > most_) Halve();
  }

 private:
  void Halve() {
    KeepEverySecond(&cloud_->points);
    KeepEverySecond(&cloud_->colors);
    stride_ *= 2;
  }
  template <typename T>
  static void KeepEverySecond(std::vector<T>* values) {
    const std::size_t kept = (values->size() + 1) / 2;
    for (std::size_t i = 0; i < kept; ++i) (*values)[i] = (*values)[2 * i];
    values->resize(kept);
  }

  std::size_t most_;
  Cloud* cloud_;
  std::uint64_t seen_ = 0, stride_ = 1;
};

// Gathers the points of a map by their sources.
class Gatherer {
 public:
  Gatherer(const Eigen::Vector3d& offset, std::size_t most, MergedMap* map)
      : laser_(most, &map->laser), vision_(most, &map->vision) {
    map->laser.offset = map->vision.offset = offset;
  }

  void Add(const char* record) {
    Eigen::Vector3f point;
    std::memcpy(point.data(), record, sizeof(float) * 3);
    if (!point.allFinite()) return;
    if (record[kPlaceOfSource] == static_cast<char>(PointSource::kVision)) {
      vision_.Add(point, record + kPlaceOfColour);
    } else {
      laser_.Add(point, nullptr);
    }
  }

 private:
  Thinned laser_, vision_;
};

}  // namespace

std::optional<MergedMap> ParseMapPly(std::istream* stream, const std::string& file,
                                     std::size_t most) {
  const std::optional<PlyHeader> header = OpenOurs(stream, file);
  if (!header) return {};
  const std::uint64_t count = header->elements.front().count;
  if (count > RecordsLeft(stream)) return {};
  MergedMap map;
  map.laser.points.reserve(std::min<std::uint64_t>(count, most));  // most maps have nothing else
  Gatherer gatherer(*header->offset, most, &map);
  const bool whole =
      ForEachBlock(stream, count, [&](std::uint64_t, std::size_t points, const char* records) {
        for (std::size_t i = 0; i < points; ++i) {
          gatherer.Add(records + i * kRecordBytes);
        }
      });
  if (!whole) return {};
  return map;
}

MergedMap ReadMapPly(const std::string& path, std::size_t most) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) {  // what a pipe gave would be gone
    std::ifstream stream(path, std::ios::binary);
    if (stream) {
      if (auto map = ParseMapPly(&stream, path, most)) return std::move(*map);
    }
  }
  // Every other file, and what is wrong with one.
  return {ReadPositions(path, "ply"), {}};
}

MapSample SampleMapPly(const std::string& path, std::size_t most) {
  MapSample sample;
  std::ifstream stream(path, std::ios::binary);
  const std::optional<PlyHeader> header = stream ? OpenOurs(&stream, path) : std::nullopt;
  if (!header || most == 0) return sample;
  const std::uint64_t count = header->elements.front().count;
  const Stretches stretches(count, most);
  std::uint64_t next = 0;
  sample.offset = *header->offset;
  ForEachBlock(&stream, count, [&](std::uint64_t first, std::size_t points, const char* records) {
    for (; next < stretches.size(); ++next) {
      const std::uint64_t at = stretches.Chosen(next) - first;
      if (at >= points) return;
      const MapPlyPoint point = ParseRecord(records + at * kRecordBytes);
      if (point.position.allFinite()) sample.points.push_back(point);
    }
  });
  sample.total = count;
  return sample;
}

}  // namespace planegraph
