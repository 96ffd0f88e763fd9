#include <nlohmann/json.hpp>

#include "planegraph/base/atomic_file.h"
#include "planegraph/segmentation/planes_json.h"
#include "segmentation/packed_array.h"

namespace planegraph {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json UpperTriangle(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

Json RowMajor(const Eigen::Matrix3d& m) {
  Json out = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out.push_back(m(row, column));
  }
  return out;
}

Json MaskToJson(const SupportMask& mask) {
  return {{"origin", ToJson(mask.origin)}, {"u", ToJson(mask.u)},   {"v", ToJson(mask.v)},
          {"cell_size", mask.cell_size},   {"min_i", mask.min_i},   {"min_j", mask.min_j},
          {"width", mask.width},           {"height", mask.height}, {"bits", PackBits(mask.cells)}};
}

Json PlaneToJson(const PlaneSegment& segment, const Eigen::Vector3d& offset) {
  Json hull = Json::array();
  for (const auto& corner : segment.hull) hull.push_back(ToJson(corner + offset));
  return {{"id", segment.id},
          {"normal", ToJson(segment.plane.normal)},
          {"distance", segment.plane.distance + segment.plane.normal.dot(offset)},
          {"centroid", ToJson(segment.centroid() + offset)},
          {"point_count", static_cast<std::int64_t>(segment.moments.count)},
          {"area", segment.area},
          {"rms", segment.rms},
          {"covariance", RowMajor(segment.covariance)},
          {"orientation", segment.orientation == Orientation::kSensor ? "sensor" : "unknown"},
          {"source", segment.source == CloudKind::kLaser ? "laser" : "vision"},
          {"hull", hull},
          {"scatter", UpperTriangle(segment.moments.scatter)},
          {"thickness", segment.thickness},
          {"mask", MaskToJson(segment.mask)}};
}

// `"name":"packed"`: Json would look at each digit of these long texts for what must be escaped.
std::string PackedMember(const char* name, const std::string& packed) {
  return std::string("\"") + name + "\":\"" + packed + "\"";
}

std::string FormatPatches(const std::vector<Patch>& patches) {
  constexpr std::size_t kValuesPerPatch = 15;
  std::vector<double> values;
  values.reserve(kValuesPerPatch * patches.size());
  std::vector<std::int32_t> segments;
  segments.reserve(patches.size());
  std::vector<std::uint8_t> sides;
  sides.reserve(patches.size());
  for (const Patch& patch : patches) {
    const Eigen::Matrix3d& s = patch.moments.scatter;
    values.push_back(patch.moments.count);
    for (int k = 0; k < 3; ++k) values.push_back(patch.moments.mean[k]);
    for (const double entry : {s(0, 0), s(0, 1), s(0, 2), s(1, 1), s(1, 2), s(2, 2)}) {
      values.push_back(entry);
    }
    for (int k = 0; k < 3; ++k) values.push_back(patch.normal[k]);
    values.push_back(patch.size);
    values.push_back(patch.sigma);
    segments.push_back(patch.segment);
    sides.push_back(patch.orientation == Orientation::kSensor);
  }
  return "{\"count\":" + std::to_string(patches.size()) + "," +
         PackedMember("values", PackArray(values)) + "," +
         PackedMember("segments", PackArray(segments)) + "," +
         PackedMember("sides", PackBits(sides)) + "}";
}

// Only the pixels that hold a return, as pairs of nearest and farthest.
std::string FormatRangeImage(const RangeImage& image) {
  std::vector<std::uint8_t> seen;
  std::vector<float> ranges;
  for (std::size_t i = 0; i < image.nearest().size(); ++i) {
    seen.push_back(image.farthest()[i] > 0.0f);
    if (!seen.back()) continue;
    ranges.push_back(image.nearest()[i]);
    ranges.push_back(image.farthest()[i]);
  }
  return "{\"viewpoint\":" + ToJson(image.viewpoint()).dump() + "," +
         PackedMember("seen", PackBits(seen)) + "," + PackedMember("ranges", PackArray(ranges)) +
         "}";
}

}  // namespace

std::string FormatPlanes(const PlaneSet& set, const std::string& stamp) {
  Json head = Json::parse(stamp);
  head["kind"] = set.kind == CloudKind::kLaser ? "laser" : "vision";
  head["offset"] = ToJson(set.offset);
  head["viewpoint"] = ToJson(set.viewpoint);
  head["point_count"] = set.point_count;
  head["noise"] = {{"constant", set.noise.constant}, {"per_metre", set.noise.per_metre}};
  std::string text = "{";
  for (const auto& [key, value] : head.items()) {
    text += Json(key).dump() + ": " + value.dump() + ",\n";
  }
  text += "\"planes\": [";
  for (const PlaneSegment& segment : set.planes) {
    text += (&segment == set.planes.data() ? "\n" : ",\n");
    text += PlaneToJson(segment, set.offset).dump();
  }
  text += "],\n\"patches\": " + FormatPatches(set.patches);
  if (!set.range_image.empty()) {
    text += ",\n\"range_image\": " + FormatRangeImage(set.range_image);
  }
  return text + "}\n";
}

void WritePlanes(const std::string& path, const PlaneSet& set, const std::string& stamp) {
  WriteTextFile(path, FormatPlanes(set, stamp));
}

}  // namespace planegraph
