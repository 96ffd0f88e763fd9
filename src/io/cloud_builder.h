#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/point_columns.h"
#include "io/text_scanner.h"
#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// What the columns of a text mean, from left to right.
struct TextColumns {
  std::vector<Role> roles;
  /// How many columns each role has, where not all have one: kSkip may have any number.
  std::vector<std::size_t> widths = {};
  char separator = ' ';
  /// Colours are multiplied by this (255 where they are written as 0..1).
  double color_scale = 1.0;
  /// A packed colour is written as the float of the same bits (PCL's habit), not as an integer.
  bool packed_is_float = false;
  /// 3DTK: left-handed centimetres.
  bool is_3dtk = false;
  /// As the file states it. Without it, one is chosen where coordinates are large.
  std::optional<Eigen::Vector3d> offset;
  /// Taken off the coordinates and given as the cloud's offset, in place of what is chosen.
  std::optional<Eigen::Vector3d> shift = {};
};

/// Collects a cloud from rows of numbers. Points that are not finite are dropped.
class CloudBuilder {
 public:
  explicit CloudBuilder(TextColumns columns);

  void Reserve(std::size_t points);
  /// Adds the point of a line. Throws InputError where a column that has a meaning holds no number,
  /// or is missing; more columns than known are ignored.
  void AddLine(std::string_view line, const std::string& file, std::size_t number);
  Cloud Take() { return std::move(cloud_); }
  /// The offset that was chosen at a point behind others, which lost digits to a float before.
  const std::optional<Eigen::Vector3d>& late_offset() const { return late_offset_; }

 private:
  using Slots = std::array<double, kRoleCount>;
  void AddSlots(const Slots& slots);
  void AddPosition(const Eigen::Vector3d& position);
  void MoveOffset(const Eigen::Vector3d& offset);

  TextColumns columns_;
  RoleSet has_;
  bool offset_is_fixed_;
  std::optional<Eigen::Vector3d> late_offset_;
  Cloud cloud_;
};

/// The cloud of the lines that add_lines(CloudBuilder*) adds: it is called again where the offset
/// comes late, so that no point is rounded before it is known.
template <typename AddLines>
Cloud BuildCloud(TextColumns columns, const AddLines& add_lines) {
  CloudBuilder builder(columns);
  add_lines(&builder);
  if (!builder.late_offset()) return builder.Take();
  columns.shift = builder.late_offset();
  builder = CloudBuilder(columns);
  add_lines(&builder);
  return builder.Take();
}

}  // namespace planegraph
