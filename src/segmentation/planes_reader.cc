#include <cmath>
#include <nlohmann/json.hpp>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/segmentation/planes_json.h"
#include "segmentation/json_node.h"
#include "segmentation/packed_array.h"

namespace planegraph {
namespace {

// Limits that no scan comes near to and that keep later steps within sane memory: metres from the
// offset, edge of a patch, cells along a mask's side.
constexpr double kMostCoordinate = 5e5, kMostPatchSize = 100.0;
constexpr std::int64_t kMostMaskSide = 1 << 16, kMostCount = std::int64_t(1) << 40;

template <typename T>
T Choose(const JsonNode& node, const char* first, T first_value, const char* second,
         T second_value) {
  if (node.String() == first) return first_value;
  if (node.String() == second) return second_value;
  node.Fail(std::string("'") + first + "' or '" + second + "' is expected");
}

CloudKind ReadKind(const JsonNode& node) {
  return Choose(node, "laser", CloudKind::kLaser, "vision", CloudKind::kVision);
}

Eigen::Matrix3d FromUpperTriangle(const double* e) {
  Eigen::Matrix3d m;
  m << e[0], e[1], e[2], e[1], e[3], e[4], e[2], e[4], e[5];
  return m;
}

Eigen::Matrix3d ReadScatter(const JsonNode& node) {
  if (node.Size() != 6) node.Fail("six numbers are expected");
  double entries[6];
  for (std::size_t k = 0; k < 6; ++k) entries[k] = node.At(k).Number();
  return FromUpperTriangle(entries);
}

Eigen::Matrix3d ReadCovariance(const JsonNode& node) {
  if (node.Size() != 9) node.Fail("nine numbers are expected");
  Eigen::Matrix3d m;
  for (int k = 0; k < 9; ++k) m(k / 3, k % 3) = node.At(k).Number();
  return m;
}

SupportMask ReadMask(const JsonNode& node) {
  SupportMask mask;
  mask.origin = node.Get("origin").Vector3(kMostCoordinate);
  mask.u = node.Get("u").UnitVector3();
  mask.v = node.Get("v").UnitVector3();
  mask.cell_size = node.Get("cell_size").Number(1e-6, 1e6);
  constexpr std::int64_t most = 1 << 30;
  mask.min_i = static_cast<int>(node.Get("min_i").Integer(-most, most));
  mask.min_j = static_cast<int>(node.Get("min_j").Integer(-most, most));
  mask.width = static_cast<int>(node.Get("width").Integer(0, kMostMaskSide));
  mask.height = static_cast<int>(node.Get("height").Integer(0, kMostMaskSide));
  const JsonNode bits = node.Get("bits");
  auto cells = UnpackBits(bits.String(), std::size_t(mask.width) * mask.height);
  if (!cells) bits.Fail("base64 of width * height bits is expected");
  mask.cells = std::move(*cells);
  return mask;
}

std::vector<Eigen::Vector3d> ReadHull(const JsonNode& node, const Eigen::Vector3d& offset) {
  std::vector<Eigen::Vector3d> hull;
  for (std::size_t k = 0; k < node.Size(); ++k) hull.push_back(node.At(k).Vector3() - offset);
  return hull;
}

PlaneSegment ReadPlane(const JsonNode& node, const Eigen::Vector3d& offset) {
  PlaneSegment segment;
  segment.id = static_cast<int>(node.Get("id").Integer(0, 1 << 30));
  segment.plane.normal = node.Get("normal").UnitVector3();
  segment.plane.distance = node.Get("distance").Number() - segment.plane.normal.dot(offset);
  segment.moments.mean = node.Get("centroid").Vector3() - offset;
  if (!(segment.moments.mean.cwiseAbs().maxCoeff() <= kMostCoordinate)) {
    node.Get("centroid").Fail("the number is out of range");
  }
  segment.moments.count = static_cast<double>(node.Get("point_count").Integer(1, kMostCount));
  segment.moments.scatter = ReadScatter(node.Get("scatter"));
  segment.axes = ComputePrincipalAxes(segment.moments.scatter);
  segment.area = node.Get("area").Number(0.0);
  segment.rms = node.Get("rms").Number(0.0);
  segment.thickness = node.Get("thickness").Number(0.0);
  segment.covariance = ReadCovariance(node.Get("covariance"));
  segment.orientation = Choose(node.Get("orientation"), "sensor", Orientation::kSensor, "unknown",
                               Orientation::kUnknown);
  segment.source = ReadKind(node.Get("source"));
  segment.hull = ReadHull(node.Get("hull"), offset);
  segment.mask = ReadMask(node.Get("mask"));
  return segment;
}

constexpr std::size_t kPatchValues = 15;

Patch MakePatch(const double* v, std::int32_t segment) {
  return {{v[0], {v[1], v[2], v[3]}, FromUpperTriangle(v + 4)},
          {v[10], v[11], v[12]},
          v[13],
          v[14],
          segment,
          Orientation::kSensor};
}

bool IsSane(const Patch& patch, std::size_t planes) {
  return patch.moments.count >= 1.0 && patch.moments.mean.allFinite() &&
         patch.moments.mean.cwiseAbs().maxCoeff() <= kMostCoordinate &&
         patch.moments.count <= static_cast<double>(kMostCount) &&
         patch.moments.scatter.allFinite() && std::abs(patch.normal.norm() - 1.0) <= 1e-6 &&
         patch.size > 0.0 && patch.size <= kMostPatchSize && patch.sigma >= 0.0 &&
         patch.sigma <= kMostCoordinate && patch.segment >= -1 &&
         patch.segment < static_cast<std::int64_t>(planes);
}

// Files without `sides`: a patch faces as surely as its plane; those of no plane as the set's
// planes do.
void GuessOrientations(PlaneSet* set) {
  const bool any = std::any_of(set->planes.begin(), set->planes.end(), [](const auto& plane) {
    return plane.orientation == Orientation::kSensor;
  });
  const bool known = set->kind == CloudKind::kLaser || any;
  for (Patch& patch : set->patches) {
    patch.orientation = patch.segment >= 0 ? set->planes[patch.segment].orientation
                        : known            ? Orientation::kSensor
                                           : Orientation::kUnknown;
  }
}

void ReadOrientations(const JsonNode& node, std::vector<Patch>* patches) {
  const auto sides = UnpackBits(node.String(), patches->size());
  if (!sides) node.Fail("base64 of one bit for each patch is expected");
  for (std::size_t i = 0; i < patches->size(); ++i) {
    (*patches)[i].orientation = (*sides)[i] ? Orientation::kSensor : Orientation::kUnknown;
  }
}

std::vector<Patch> ReadPatches(const JsonNode& node, std::size_t planes) {
  const auto values = UnpackArray<double>(node.Get("values").String());
  if (!values || values->size() % kPatchValues != 0) {
    node.Get("values").Fail("base64 of 15 doubles for each patch is expected");
  }
  const std::size_t count = values->size() / kPatchValues;
  if (node.Get("count").Integer(0, kMostCount) != static_cast<std::int64_t>(count)) {
    node.Get("count").Fail("does not fit the number of values");
  }
  const auto segments = UnpackArray<std::int32_t>(node.Get("segments").String());
  if (!segments || segments->size() != count) {
    node.Get("segments").Fail("base64 of one 32-bit integer for each patch is expected");
  }
  std::vector<Patch> patches;
  for (std::size_t i = 0; i < count; ++i) {
    patches.push_back(MakePatch(values->data() + kPatchValues * i, (*segments)[i]));
    if (!IsSane(patches.back(), planes)) {
      node.Get("values").Fail("patch " + std::to_string(i) + " is not valid");
    }
  }
  return patches;
}

RangeImage ReadRangeImage(const JsonNode& node) {
  const auto seen = UnpackBits(node.Get("seen").String(), RangeImage::kPixels);
  if (!seen) node.Get("seen").Fail("base64 of one bit for each pixel is expected");
  const auto ranges = UnpackArray<float>(node.Get("ranges").String());
  if (!ranges) node.Get("ranges").Fail("base64 of floats is expected");
  std::vector<float> nearest(RangeImage::kPixels, INFINITY), farthest(RangeImage::kPixels, 0.0f);
  std::size_t next = 0;
  for (std::size_t i = 0; i < seen->size(); ++i) {
    if (!(*seen)[i]) continue;
    if (next + 2 > ranges->size()) node.Get("ranges").Fail("too few values");
    nearest[i] = (*ranges)[next++];
    farthest[i] = (*ranges)[next++];
    const bool sane = nearest[i] >= 0.0f && farthest[i] >= nearest[i] && std::isfinite(farthest[i]);
    if (!sane) node.Get("ranges").Fail("pixel " + std::to_string(i) + " is not valid");
  }
  if (next != ranges->size()) node.Get("ranges").Fail("too many values");
  return {node.Get("viewpoint").Vector3(), std::move(nearest), std::move(farthest)};
}

nlohmann::json ParseJson(std::string_view text, const std::string& name) {
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    throw InputError::AtByte(name, error.byte, "not valid JSON");
  } catch (const nlohmann::json::exception&) {
    throw InputError::InFile(name, "JSON with a number that is out of range");
  }
}

}  // namespace

PlaneSet ParsePlanes(std::string_view text, const std::string& name) {
  const nlohmann::json json = ParseJson(text, name);
  const JsonNode root(json, name);
  PlaneSet set;
  set.kind = ReadKind(root.Get("kind"));
  set.offset = root.Get("offset").Vector3();
  set.viewpoint = root.Get("viewpoint").Vector3();
  set.point_count = static_cast<std::size_t>(root.Get("point_count").Integer(0, kMostCount));
  set.noise.constant = root.Get("noise").Get("constant").Number(0.0);
  set.noise.per_metre = root.Get("noise").Get("per_metre").Number(0.0);
  const JsonNode planes = root.Get("planes");
  for (std::size_t i = 0; i < planes.Size(); ++i) {
    set.planes.push_back(ReadPlane(planes.At(i), set.offset));
  }
  set.patches = ReadPatches(root.Get("patches"), set.planes.size());
  if (root.Get("patches").Has("sides")) {
    ReadOrientations(root.Get("patches").Get("sides"), &set.patches);
  } else {
    GuessOrientations(&set);
  }
  if (root.Has("range_image")) set.range_image = ReadRangeImage(root.Get("range_image"));
  return set;
}

PlaneSet ReadPlanes(const std::string& path) { return ParsePlanes(ReadTextFile(path), path); }

}  // namespace planegraph
