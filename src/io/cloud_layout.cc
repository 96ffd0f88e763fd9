#include "io/cloud_layout.h"

#include <algorithm>

#include "io/cloud_formats.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

void CheckFits(const CloudLayout& layout, std::uint64_t size, const std::string& file) {
  if (layout.is_text) {
    CheckLinesFit(size, layout.body, layout.count, layout.words, file);
  } else {
    CheckRecordsFit(size, layout.body, layout.count, layout.stride, file);
  }
}

// Moves the body behind the elements before the vertices; false where their length is not known.
bool SkipElements(const PlyHeader& header, const PlyElement& vertex, std::uint64_t size,
                  const std::string& file, CloudLayout* layout) {
  for (const PlyElement& element : header.elements) {
    if (&element == &vertex) return true;
    if (element.HasLists() || (layout->is_text && !element.properties.empty())) return false;
    if (layout->is_text) continue;
    CheckRecordsFit(size, layout->body, element.count, element.FixedBytes(), file);
    layout->body += element.count * element.FixedBytes();
  }
  return true;
}

}  // namespace

PointColumns CloudLayout::ColumnsAt(const char* first, std::size_t count_here) const {
  PointColumns columns;
  columns.count = count_here;
  columns.swap_bytes = swap_bytes;
  columns.offset = offset;
  for (const Field& field : fields) {
    columns.columns.push_back({field.role, field.type, first + field.place, stride});
  }
  return columns;
}

std::vector<Role> RolesOf(const PlyElement& vertex) {
  std::vector<Role> roles;
  for (const PlyProperty& property : vertex.properties) {
    roles.push_back(property.is_list ? Role::kSkip : RoleOfName(property.name));
  }
  SkipRepeatedRoles(&roles);
  return roles;
}

std::vector<Role> RolesOf(const PcdHeader& header, const std::string& file) {
  std::vector<Role> roles;
  for (const PcdField& field : header.fields) {
    roles.push_back(field.count == 1 ? RoleOfName(field.name) : Role::kSkip);
  }
  SkipRepeatedRoles(&roles);
  if (!RoleSet(roles).position) throw InputError::InFile(file, "its FIELDS have no x, y, z");
  return roles;
}

const PlyElement& FindVertices(const PlyHeader& header, const std::string& file) {
  const auto found = std::find_if(header.elements.begin(), header.elements.end(),
                                  [](const PlyElement& e) { return e.name == "vertex"; });
  if (found == header.elements.end()) throw InputError::InFile(file, "holds no element 'vertex'");
  if (!RoleSet(RolesOf(*found)).position) {
    throw InputError::InFile(file, "its vertices have no x, y, z");
  }
  return *found;
}

TextColumns TextColumnsOf(const PlyElement& vertex, const PlyHeader& header) {
  TextColumns columns;
  columns.offset = header.offset;
  const std::vector<Role> roles = RolesOf(vertex);
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const PlyProperty& property = vertex.properties[i];
    if (property.is_list) continue;
    columns.roles.push_back(roles[i]);
    if (roles[i] == Role::kPackedColor) columns.packed_is_float = IsFloating(property.type);
    if (roles[i] == Role::kRed && IsFloating(property.type)) columns.color_scale = 255.0;
    if (roles[i] == Role::kRed && property.type == ScalarType::kUint16) {
      columns.color_scale = 1.0 / 257.0;
    }
  }
  return columns;
}

TextColumns TextColumnsOf(const PcdHeader& header, const std::vector<Role>& roles) {
  TextColumns columns;
  columns.offset = header.offset;
  columns.roles = roles;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    columns.widths.push_back(header.fields[i].count);
    const bool is_float = IsFloating(header.fields[i].type);
    if (roles[i] == Role::kPackedColor) columns.packed_is_float = is_float;
    if (roles[i] == Role::kRed && is_float) columns.color_scale = 255.0;
  }
  return columns;
}

std::optional<CloudLayout> LayoutOf(const PlyHeader& header, std::uint64_t size,
                                    const std::string& file) {
  const PlyElement& vertex = FindVertices(header, file);
  CloudLayout layout;
  layout.count = vertex.count;
  layout.body = header.body;
  layout.is_text = header.encoding == PlyEncoding::kAscii;
  layout.offset = header.offset;
  layout.viewpoint = header.viewpoint.value_or(Eigen::Vector3d::Zero());
  layout.lines = header.lines;
  layout.lines_are = "lines of 'vertex'";
  layout.words = vertex.properties.size();
  layout.swap_bytes = header.encoding == PlyEncoding::kBigEndian;
  if (vertex.HasLists() || !SkipElements(header, vertex, size, file, &layout)) return {};
  const std::vector<Role> roles = RolesOf(vertex);
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const ScalarType type = vertex.properties[i].type;
    if (roles[i] != Role::kSkip) layout.fields.push_back({roles[i], type, layout.stride});
    layout.stride += SizeOf(type);
  }
  if (layout.is_text) layout.text = TextColumnsOf(vertex, header);
  CheckFits(layout, size, file);
  return layout;
}

std::optional<CloudLayout> LayoutOf(const PcdHeader& header, std::uint64_t size,
                                    const std::string& file) {
  const std::vector<Role> roles = RolesOf(header, file);
  if (header.data == PcdData::kCompressed) return {};
  CloudLayout layout;
  layout.count = header.points;
  layout.body = header.body;
  layout.is_text = header.data == PcdData::kAscii;
  layout.offset = header.offset;
  layout.viewpoint = header.offset.value_or(Eigen::Vector3d::Zero()) + header.viewpoint;
  layout.lines = header.lines;
  layout.lines_are = "points";
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const PcdField& field = header.fields[i];
    if (roles[i] != Role::kSkip) layout.fields.push_back({roles[i], field.type, layout.stride});
    layout.stride += field.Bytes();
  }
  if (layout.is_text) layout.text = TextColumnsOf(header, roles);
  layout.words = header.PointValues();
  CheckFits(layout, size, file);
  return layout;
}

}  // namespace planegraph
