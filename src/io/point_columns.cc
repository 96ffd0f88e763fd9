#include "io/point_columns.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "io/text_scanner.h"

namespace planegraph {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the readers assume a little-endian host");

template <typename T, bool kSwap>
T Load(const char* from) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, from, sizeof(T));
  if constexpr (kSwap) std::reverse(bytes, bytes + sizeof(T));
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

template <typename T, bool kSwap, typename Store>
void LoadColumn(const Column& column, std::size_t count, const Store& store) {
  const char* from = column.first;
  for (std::size_t i = 0; i < count; ++i, from += column.stride) store(i, Load<T, kSwap>(from));
}

template <bool kSwap, typename Store>
void DispatchType(const Column& c, std::size_t n, const Store& store) {
  switch (c.type) {
    case ScalarType::kInt8:
      return LoadColumn<std::int8_t, kSwap>(c, n, store);
    case ScalarType::kUint8:
      return LoadColumn<std::uint8_t, kSwap>(c, n, store);
    case ScalarType::kInt16:
      return LoadColumn<std::int16_t, kSwap>(c, n, store);
    case ScalarType::kUint16:
      return LoadColumn<std::uint16_t, kSwap>(c, n, store);
    case ScalarType::kInt32:
      return LoadColumn<std::int32_t, kSwap>(c, n, store);
    case ScalarType::kUint32:
      return LoadColumn<std::uint32_t, kSwap>(c, n, store);
    case ScalarType::kInt64:
      return LoadColumn<std::int64_t, kSwap>(c, n, store);
    case ScalarType::kUint64:
      return LoadColumn<std::uint64_t, kSwap>(c, n, store);
    case ScalarType::kFloat32:
      return LoadColumn<float, kSwap>(c, n, store);
    case ScalarType::kFloat64:
      return LoadColumn<double, kSwap>(c, n, store);
  }
}

// Calls store(i, value) for every value of the column, with the value in its own type.
template <typename Store>
void ForEachValue(const PointColumns& source, const Column& column, const Store& store) {
  if (source.swap_bytes) {
    DispatchType<true>(column, source.count, store);
  } else {
    DispatchType<false>(column, source.count, store);
  }
}

using RoleIndex = std::array<const Column*, kRoleCount>;

const Column& At(const RoleIndex& index, Role role, int axis = 0) {
  return *index[static_cast<std::size_t>(role) + static_cast<std::size_t>(axis)];
}

RoleIndex IndexRoles(const PointColumns& source) {
  RoleIndex index{};
  for (const Column& column : source.columns) {
    const Column*& slot = index[static_cast<std::size_t>(column.role)];
    if (!slot) slot = &column;
  }
  return index;
}

void LoadVectors(const PointColumns& source, const RoleIndex& index, Role first,
                 std::vector<Eigen::Vector3f>* out) {
  out->resize(source.count);
  for (int axis = 0; axis < 3; ++axis) {
    ForEachValue(source, At(index, first, axis),
                 [&](std::size_t i, auto value) { (*out)[i][axis] = static_cast<float>(value); });
  }
}

// x y z as neighbouring floats of this host's byte order, which nearly all files have.
bool IsFloatTriple(const PointColumns& source, const RoleIndex& index) {
  const Column &x = At(index, Role::kX), &y = At(index, Role::kY), &z = At(index, Role::kZ);
  const auto is_float = [](const Column& c) { return c.type == ScalarType::kFloat32; };
  return !source.swap_bytes && is_float(x) && is_float(y) && is_float(z) && x.stride == y.stride &&
         x.stride == z.stride && x.first + 4 == y.first && y.first + 4 == z.first;
}

void LoadFloatTriples(const Column& x, std::size_t count, std::vector<Eigen::Vector3f>* points) {
  constexpr std::size_t kTriple = 3 * sizeof(float);
  static_assert(sizeof(Eigen::Vector3f) == kTriple);
  points->resize(count);
  if (x.stride == kTriple) {
    std::memcpy(points->data()->data(), x.first, count * kTriple);
    return;
  }
  const char* from = x.first;
  for (std::size_t i = 0; i < count; ++i, from += x.stride) {
    std::memcpy((*points)[i].data(), from, kTriple);
  }
}

// Doubles (and integers, which a float may not hold) go through the offset of the first large
// point.
void LoadWidePoints(const PointColumns& source, const RoleIndex& index, Cloud* cloud) {
  std::vector<Eigen::Vector3d> wide(source.count);
  for (int axis = 0; axis < 3; ++axis) {
    ForEachValue(source, At(index, Role::kX, axis),
                 [&](std::size_t i, auto value) { wide[i][axis] = static_cast<double>(value); });
  }
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  const auto large = std::find_if(wide.begin(), wide.end(), [](const Eigen::Vector3d& p) {
    return p.allFinite() && IsLarge(p);
  });
  if (!source.offset && large != wide.end()) shift = large->array().round();
  if (source.shift) shift = *source.shift;
  cloud->offset += shift;
  cloud->points.resize(source.count);
  for (std::size_t i = 0; i < source.count; ++i) {
    cloud->points[i] = (wide[i] - shift).cast<float>();
  }
}

void LoadPoints(const PointColumns& source, const RoleIndex& index, Cloud* cloud) {
  cloud->offset = source.offset.value_or(Eigen::Vector3d::Zero());
  bool narrow = true;
  for (int axis = 0; axis < 3; ++axis) {
    const ScalarType type = At(index, Role::kX, axis).type;
    narrow = narrow && (type == ScalarType::kFloat32 || SizeOf(type) <= 2);
  }
  if (IsFloatTriple(source, index)) {
    LoadFloatTriples(At(index, Role::kX), source.count, &cloud->points);
  } else if (narrow) {
    LoadVectors(source, index, Role::kX, &cloud->points);
  } else {
    LoadWidePoints(source, index, cloud);
  }
}

// Floating colours run from 0 to 1, 16-bit ones to 65535.
double ChannelScale(ScalarType type) {
  if (IsFloating(type)) return 255.0;
  return type == ScalarType::kUint16 ? 1.0 / 257.0 : 1.0;
}

void LoadColors(const PointColumns& source, const RoleIndex& index, Cloud* cloud) {
  cloud->colors.resize(source.count);
  for (int axis = 0; axis < 3; ++axis) {
    const Column& column = At(index, Role::kRed, axis);
    const double scale = ChannelScale(column.type);
    auto& colors = cloud->colors;
    ForEachValue(source, column, [&](std::size_t i, auto value) {
      auto& channel = colors[i][static_cast<std::size_t>(axis)];
      if constexpr (std::is_same_v<decltype(value), std::uint8_t>) {
        channel = value;
      } else {
        channel = ToChannel(static_cast<double>(value) * scale);
      }
    });
  }
}

void LoadPackedColors(const PointColumns& source, const Column& column, Cloud* cloud) {
  cloud->colors.resize(source.count);
  ForEachValue(source, column, [&](std::size_t i, auto value) {
    if constexpr (std::is_same_v<decltype(value), float>) {
      cloud->colors[i] = UnpackColor(std::bit_cast<std::uint32_t>(value));
    } else if constexpr (std::is_integral_v<decltype(value)>) {
      cloud->colors[i] = UnpackColor(static_cast<std::uint32_t>(value));
    }
  });
}

void LoadIntensities(const PointColumns& source, const Column& column, Cloud* cloud) {
  cloud->intensities.resize(source.count);
  ForEachValue(source, column, [&](std::size_t i, auto value) {
    cloud->intensities[i] = static_cast<float>(value);
  });
}

// All exponent bits set mean infinite or NaN; written so that it vectorizes.
bool AllFinite(const std::vector<Eigen::Vector3f>& points) {
  std::uint32_t found = 0;
  for (const Eigen::Vector3f& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      constexpr std::uint32_t kExponent = 0x7f800000u;
      found |= (std::bit_cast<std::uint32_t>(point[axis]) & kExponent) == kExponent ? 1u : 0u;
    }
  }
  return found == 0;
}

Cloud WithoutNonFinite(Cloud cloud) {
  if (AllFinite(cloud.points)) return cloud;
  std::vector<std::uint32_t> kept;
  kept.reserve(cloud.size());
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    if (cloud.points[i].allFinite()) kept.push_back(i);
  }
  return Select(cloud, kept);
}

}  // namespace

std::size_t SizeOf(ScalarType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

Role RoleOfName(std::string_view name) {
  static const std::map<std::string, Role, std::less<>> kRoles = {
      {"x", Role::kX},
      {"y", Role::kY},
      {"z", Role::kZ},
      {"nx", Role::kNormalX},
      {"ny", Role::kNormalY},
      {"nz", Role::kNormalZ},
      {"normal_x", Role::kNormalX},
      {"normal_y", Role::kNormalY},
      {"normal_z", Role::kNormalZ},
      {"r", Role::kRed},
      {"g", Role::kGreen},
      {"b", Role::kBlue},
      {"red", Role::kRed},
      {"green", Role::kGreen},
      {"blue", Role::kBlue},
      {"diffuse_red", Role::kRed},
      {"diffuse_green", Role::kGreen},
      {"diffuse_blue", Role::kBlue},
      {"intensity", Role::kIntensity},
      {"scalar_intensity", Role::kIntensity},
      {"reflectance", Role::kIntensity},
      {"i", Role::kIntensity},
      {"rgb", Role::kPackedColor},
      {"rgba", Role::kPackedColor}};
  const auto found = kRoles.find(ToLower(name));
  return found == kRoles.end() ? Role::kSkip : found->second;
}

RoleSet::RoleSet(const std::vector<Role>& roles) {
  std::array<bool, kRoleCount> has{};
  for (const Role role : roles) has[static_cast<std::size_t>(role)] = true;
  const auto triple = [&](Role first) {
    const auto at = static_cast<std::size_t>(first);
    return has[at] && has[at + 1] && has[at + 2];
  };
  position = triple(Role::kX);
  normal = triple(Role::kNormalX);
  color = triple(Role::kRed);
  packed_color = !color && has[static_cast<std::size_t>(Role::kPackedColor)];
  intensity = has[static_cast<std::size_t>(Role::kIntensity)];
}

void SkipRepeatedRoles(std::vector<Role>* roles) {
  std::array<bool, kRoleCount> seen{};
  for (Role& role : *roles) {
    bool& before = seen[static_cast<std::size_t>(role)];
    if (before) role = Role::kSkip;
    before = true;
  }
}

Cloud AssembleCloud(const PointColumns& source) {
  const RoleIndex index = IndexRoles(source);
  std::vector<Role> roles;
  for (const Column& column : source.columns) roles.push_back(column.role);
  const RoleSet has(roles);
  Cloud cloud;
  if (!has.position || source.count == 0) return cloud;
  LoadPoints(source, index, &cloud);
  if (has.normal) LoadVectors(source, index, Role::kNormalX, &cloud.normals);
  if (has.color) LoadColors(source, index, &cloud);
  if (has.packed_color) LoadPackedColors(source, At(index, Role::kPackedColor), &cloud);
  if (has.intensity) LoadIntensities(source, At(index, Role::kIntensity), &cloud);
  return WithoutNonFinite(std::move(cloud));
}

bool IsUsable(const Eigen::Vector3d& position) {
  constexpr double kFarthest = 1e30;
  return position.allFinite() && position.cwiseAbs().maxCoeff() < kFarthest;
}

bool IsLarge(const Eigen::Vector3d& position) {
  constexpr double kLarge = 1e4, kUnreasonable = 1e12;
  const double largest = position.cwiseAbs().maxCoeff();
  return largest > kLarge && largest < kUnreasonable;
}

std::array<std::uint8_t, 3> UnpackColor(std::uint32_t packed) {
  return {static_cast<std::uint8_t>(packed >> 16), static_cast<std::uint8_t>(packed >> 8),
          static_cast<std::uint8_t>(packed)};
}

std::uint8_t ToChannel(double value) {
  if (!(value > 0.0)) return 0;
  return static_cast<std::uint8_t>(std::lround(std::min(value, 255.0)));
}

}  // namespace planegraph
