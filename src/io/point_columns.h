#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// The number types of PLY and PCD.
enum class ScalarType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64
};
std::size_t SizeOf(ScalarType type);
inline bool IsFloating(ScalarType type) { return type >= ScalarType::kFloat32; }

/// What a column of a file means to a cloud.
enum class Role : std::uint8_t {
  kX,
  kY,
  kZ,
  kNormalX,
  kNormalY,
  kNormalZ,
  kRed,
  kGreen,
  kBlue,
  kIntensity,
  kPackedColor,
  kSkip
};
inline constexpr std::size_t kRoleCount = static_cast<std::size_t>(Role::kSkip) + 1;

/// The role of a column of that name (letter case ignored), kSkip for others.
Role RoleOfName(std::string_view name);
/// Which of the roles occur; whole groups (three of colour, three of normal) only.
struct RoleSet {
  bool position = false, normal = false, color = false, packed_color = false, intensity = false;
  explicit RoleSet(const std::vector<Role>& roles);
};
/// Every role but kSkip once: later columns of the same role become kSkip.
void SkipRepeatedRoles(std::vector<Role>* roles);

/// One column of binary records: value i lies at first + i * stride.
struct Column {
  Role role;
  ScalarType type;
  const char* first;
  std::size_t stride;
};

/// Binary point data whose extent has been checked. `offset`: as the file states it; without it,
/// one is chosen where double coordinates are large.
struct PointColumns {
  std::vector<Column> columns;
  std::size_t count = 0;
  bool swap_bytes = false;
  std::optional<Eigen::Vector3d> offset;
  /// Taken off double coordinates and given as the cloud's offset, in place of what is chosen.
  std::optional<Eigen::Vector3d> shift = {};
};

/// The cloud of those columns, without its points that are not finite.
Cloud AssembleCloud(const PointColumns& source);

/// True where a point can be kept: finite, and a float holds it (less than 1e30 m).
bool IsUsable(const Eigen::Vector3d& position);
/// True where the coordinates call for an offset: more than 10 km; not where they are beyond all
/// reason (1e12 m), so that a stray value does not cost the others their digits.
bool IsLarge(const Eigen::Vector3d& position);
/// Splits 0xRRGGBB.
std::array<std::uint8_t, 3> UnpackColor(std::uint32_t packed);
/// A colour channel of any scale as 0..255, clamped; NaN is 0.
std::uint8_t ToChannel(double value);

}  // namespace planegraph
