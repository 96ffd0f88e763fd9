#include <cstring>

#include "io/cloud_builder.h"
#include "io/cloud_formats.h"
#include "io/cloud_layout.h"
#include "io/lzf.h"
#include "io/pcd_header.h"
#include "io/point_columns.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

Cloud ParseAscii(std::string_view bytes, const PcdHeader& header, const std::vector<Role>& roles,
                 const std::string& file) {
  CheckLinesFit(bytes.size(), header.body, header.points, header.PointValues(), file);
  return BuildCloud(TextColumnsOf(header, roles), [&](CloudBuilder* builder) {
    builder->Reserve(header.points);
    LineReader lines(bytes.substr(header.body), header.lines + 1);
    std::string_view line;
    for (std::uint64_t have = 0; have < header.points;) {
      if (!lines.Next(&line)) {
        throw InputError::AtLine(file, lines.number(),
                                 "the file ends after " + std::to_string(have) + " of " +
                                     std::to_string(header.points) + " points");
      }
      if (Trim(line).empty()) continue;
      builder->AddLine(line, file, lines.number());
      ++have;
    }
  });
}

// In `binary` the fields of a point lie together, in `binary_compressed` the points of a field.
Cloud Assemble(const char* data, const PcdHeader& header, const std::vector<Role>& roles,
               bool by_field) {
  PointColumns columns;
  columns.count = header.points;
  columns.offset = header.offset;
  std::size_t before = 0;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const PcdField& field = header.fields[i];
    const char* first = data + before * (by_field ? header.points : 1);
    const std::size_t stride = by_field ? field.Bytes() : header.PointBytes();
    if (roles[i] != Role::kSkip) columns.columns.push_back({roles[i], field.type, first, stride});
    before += field.Bytes();
  }
  return AssembleCloud(columns);
}

std::uint32_t LoadUint32(const char* from) {
  std::uint32_t value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

Cloud ParseCompressed(std::string_view bytes, const PcdHeader& header,
                      const std::vector<Role>& roles, const std::string& file) {
  CheckRecordsFit(bytes, header.body, 2, sizeof(std::uint32_t), file);
  const std::size_t packed = LoadUint32(bytes.data() + header.body);
  const std::size_t unpacked = LoadUint32(bytes.data() + header.body + 4);
  const std::size_t start = header.body + 8;
  CheckRecordsFit(bytes, start, packed, 1, file);
  if (unpacked % header.PointBytes() != 0 || unpacked / header.PointBytes() != header.points) {
    throw InputError::AtByte(file, header.body + 4,
                             "the unpacked size is not POINTS times the size of a point");
  }
  if (unpacked / kLzfLargestRatio > packed) {
    throw InputError::AtByte(file, header.body, "the compressed data are too short for all points");
  }
  const auto data = UnpackLzf(bytes.substr(start, packed), unpacked, file, start);
  return Assemble(data.data(), header, roles, true);
}

}  // namespace

Cloud ParsePcd(std::string_view bytes, const std::string& file) {
  const PcdHeader header = ParsePcdHeader(bytes, file);
  const std::vector<Role> roles = RolesOf(header, file);
  Cloud cloud;
  if (header.points == 0) return cloud;
  if (header.data == PcdData::kAscii) {
    cloud = ParseAscii(bytes, header, roles, file);
  } else if (header.data == PcdData::kBinary) {
    CheckRecordsFit(bytes, header.body, header.points, header.PointBytes(), file);
    cloud = Assemble(bytes.data() + header.body, header, roles, false);
  } else {
    cloud = ParseCompressed(bytes, header, roles, file);
  }
  cloud.viewpoint = header.offset.value_or(Eigen::Vector3d::Zero()) + header.viewpoint;
  return cloud;
}

}  // namespace planegraph
