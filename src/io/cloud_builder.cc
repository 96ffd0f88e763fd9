#include "io/cloud_builder.h"

#include <bit>
#include <cmath>
#include <limits>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

double At(const std::array<double, kRoleCount>& slots, Role role) {
  return slots[static_cast<std::size_t>(role)];
}

std::uint32_t PackedBits(double value, bool is_float) {
  if (is_float) return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  const bool fits = value >= 0.0 && value <= std::numeric_limits<std::uint32_t>::max();
  return fits ? static_cast<std::uint32_t>(value) : 0u;
}

}  // namespace

CloudBuilder::CloudBuilder(TextColumns columns)
    : columns_(std::move(columns)),
      has_(columns_.roles),
      offset_is_fixed_(columns_.offset || columns_.shift) {
  cloud_.offset = columns_.offset.value_or(columns_.shift.value_or(Eigen::Vector3d::Zero()));
}

void CloudBuilder::Reserve(std::size_t points) {
  cloud_.points.reserve(points);
  if (has_.normal) cloud_.normals.reserve(points);
  if (has_.color || has_.packed_color) cloud_.colors.reserve(points);
  if (has_.intensity) cloud_.intensities.reserve(points);
}

void CloudBuilder::AddLine(std::string_view line, const std::string& file, std::size_t number) {
  Slots slots{};
  FieldReader fields(line, columns_.separator);
  std::size_t column = 0;
  for (std::size_t i = 0; i < columns_.roles.size(); ++i) {
    const Role role = columns_.roles[i];
    const std::size_t width = columns_.widths.empty() ? 1 : columns_.widths[i];
    auto result = FieldReader::Result::kNumber;
    for (std::size_t k = 0; k < width && result != FieldReader::Result::kEnd; ++k) {
      result = fields.Next(&slots[static_cast<std::size_t>(role)]);
    }
    column += width;
    if (result == FieldReader::Result::kNumber || role == Role::kSkip) continue;
    const bool missing = result == FieldReader::Result::kEnd;
    throw InputError::AtLine(file, number,
                             "column " + std::to_string(column) +
                                 (missing ? " is missing in " : " is not a number in ") +
                                 Excerpt(line));
  }
  AddSlots(slots);
}

void CloudBuilder::AddSlots(const Slots& slots) {
  Eigen::Vector3d position(At(slots, Role::kX), At(slots, Role::kY), At(slots, Role::kZ));
  if (!IsUsable(position)) return;
  if (columns_.is_3dtk) position = Eigen::Vector3d(position.z(), -position.x(), position.y()) / 100;
  AddPosition(position);
  if (has_.normal) {
    cloud_.normals.emplace_back(static_cast<float>(At(slots, Role::kNormalX)),
                                static_cast<float>(At(slots, Role::kNormalY)),
                                static_cast<float>(At(slots, Role::kNormalZ)));
  }
  if (has_.color) {
    const double scale = columns_.color_scale;
    cloud_.colors.push_back({ToChannel(scale * At(slots, Role::kRed)),
                             ToChannel(scale * At(slots, Role::kGreen)),
                             ToChannel(scale * At(slots, Role::kBlue))});
  } else if (has_.packed_color) {
    const double packed = At(slots, Role::kPackedColor);
    cloud_.colors.push_back(UnpackColor(PackedBits(packed, columns_.packed_is_float)));
  }
  if (has_.intensity) {
    cloud_.intensities.push_back(static_cast<float>(At(slots, Role::kIntensity)));
  }
}

void CloudBuilder::AddPosition(const Eigen::Vector3d& position) {
  const bool relative = columns_.offset.has_value();
  if (!offset_is_fixed_ && IsLarge(position)) MoveOffset(position.array().round());
  cloud_.points.push_back((relative ? position : position - cloud_.offset).cast<float>());
}

// The first large point decides. Smaller ones before it (often dummies at zero) are moved over.
void CloudBuilder::MoveOffset(const Eigen::Vector3d& offset) {
  for (Eigen::Vector3f& point : cloud_.points)
    point = (point.cast<double>() - offset).cast<float>();
  if (!cloud_.points.empty()) late_offset_ = offset;
  cloud_.offset = offset;
  offset_is_fixed_ = true;
}

}  // namespace planegraph
