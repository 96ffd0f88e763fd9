#include <algorithm>
#include <bit>
#include <cstring>

#include "io/cloud_builder.h"
#include "io/cloud_formats.h"
#include "io/cloud_layout.h"
#include "io/ply_header.h"
#include "io/point_columns.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

// ---- binary ----

std::uint64_t LoadCount(const char* from, ScalarType type, bool swap) {
  char bytes[8] = {};
  const std::size_t size = SizeOf(type);
  std::memcpy(bytes, from, size);
  if (swap) std::reverse(bytes, bytes + size);
  return std::bit_cast<std::uint64_t>(bytes);
}

// The end of the binary record at `position`. Where `fixed` is given, its fields that are no lists
// are appended there.
std::size_t WalkRecord(std::string_view bytes, std::size_t position, const PlyElement& element,
                       bool swap, const std::string& file, std::vector<char>* fixed) {
  for (const PlyProperty& property : element.properties) {
    std::uint64_t count = 1;
    if (property.is_list) {
      CheckRecordsFit(bytes, position, 1, SizeOf(property.count_type), file);
      count = LoadCount(bytes.data() + position, property.count_type, swap);
      position += SizeOf(property.count_type);
    }
    const std::size_t size = SizeOf(property.type);
    CheckRecordsFit(bytes, position, count, size, file);
    const char* from = bytes.data() + position;
    if (fixed && !property.is_list) fixed->insert(fixed->end(), from, from + size);
    position += count * size;
  }
  return position;
}

// Least bytes of a record: its fields, and an empty list's count for each list.
std::size_t LeastBytes(const PlyElement& element) {
  std::size_t bytes = element.FixedBytes();
  for (const PlyProperty& p : element.properties) bytes += p.is_list ? SizeOf(p.count_type) : 0;
  return bytes;
}

std::size_t SkipElement(std::string_view bytes, std::size_t position, const PlyElement& element,
                        bool swap, const std::string& file) {
  CheckRecordsFit(bytes, position, element.count, LeastBytes(element), file);
  if (!element.HasLists()) return position + element.count * element.FixedBytes();
  for (std::uint64_t i = 0; i < element.count; ++i) {
    position = WalkRecord(bytes, position, element, swap, file, nullptr);
  }
  return position;
}

Cloud AssembleVertices(const char* records, const PlyElement& vertex, const PlyHeader& header) {
  PointColumns columns;
  columns.count = vertex.count;
  columns.swap_bytes = header.encoding == PlyEncoding::kBigEndian;
  columns.offset = header.offset;
  const std::vector<Role> roles = RolesOf(vertex);
  const std::size_t stride = vertex.FixedBytes();
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const PlyProperty& property = vertex.properties[i];
    if (property.is_list) continue;
    if (roles[i] != Role::kSkip)
      columns.columns.push_back({roles[i], property.type, records, stride});
    records += SizeOf(property.type);
  }
  return AssembleCloud(columns);
}

Cloud ParseBinary(std::string_view bytes, const PlyHeader& header, const PlyElement& vertex,
                  const std::string& file) {
  const bool swap = header.encoding == PlyEncoding::kBigEndian;
  std::size_t position = header.body;
  for (const PlyElement& element : header.elements) {
    if (&element == &vertex) break;
    position = SkipElement(bytes, position, element, swap, file);
  }
  CheckRecordsFit(bytes, position, vertex.count, LeastBytes(vertex), file);
  if (!vertex.HasLists()) return AssembleVertices(bytes.data() + position, vertex, header);
  std::vector<char> fixed;
  fixed.reserve(vertex.count * vertex.FixedBytes());
  for (std::uint64_t i = 0; i < vertex.count; ++i) {
    position = WalkRecord(bytes, position, vertex, swap, file, &fixed);
  }
  return AssembleVertices(fixed.data(), vertex, header);
}

// ---- ascii ----

bool NextFilledLine(LineReader* lines, std::string_view* line) {
  while (lines->Next(line)) {
    if (!Trim(*line).empty()) return true;
  }
  return false;
}

[[noreturn]] void FailAtEnd(const LineReader& lines, const PlyElement& element, std::uint64_t have,
                            const std::string& file) {
  throw InputError::AtLine(file, lines.number(),
                           "the file ends after " + std::to_string(have) + " of " +
                               std::to_string(element.count) + " lines of '" + element.name + "'");
}

// The fields of a line without its lists.
std::string WithoutLists(std::string_view line, const PlyElement& vertex, const std::string& file,
                         std::size_t number) {
  const auto words = SplitWords(line);
  std::string rest;
  std::size_t at = 0;
  for (const PlyProperty& property : vertex.properties) {
    long long count = 0;
    if (at >= words.size()) throw InputError::AtLine(file, number, "columns are missing");
    if (!property.is_list) {
      rest.append(words[at]) += ' ';
    } else if (!ParseInteger(words[at], &count) || count < 0 ||
               static_cast<std::size_t>(count) >= words.size() - at) {
      throw InputError::AtLine(file, number, "a list's count is wrong: " + Excerpt(words[at]));
    }
    at += static_cast<std::size_t>(count) + 1;
  }
  return rest;
}

Cloud ParseAscii(std::string_view bytes, const PlyHeader& header, const PlyElement& vertex,
                 const std::string& file) {
  LineReader lines(bytes.substr(header.body), header.lines + 1);
  std::string_view line;
  for (const PlyElement& element : header.elements) {
    if (&element == &vertex) break;
    for (std::uint64_t i = 0; !element.properties.empty() && i < element.count; ++i) {
      if (!NextFilledLine(&lines, &line)) FailAtEnd(lines, element, i, file);
    }
  }
  CheckLinesFit(bytes.size(), header.body + lines.position(), vertex.count,
                vertex.properties.size(), file);
  const bool has_lists = vertex.HasLists();
  return BuildCloud(TextColumnsOf(vertex, header), [&](CloudBuilder* builder) {
    builder->Reserve(vertex.count);
    LineReader left = lines;
    for (std::uint64_t i = 0; i < vertex.count; ++i) {
      if (!NextFilledLine(&left, &line)) FailAtEnd(left, vertex, i, file);
      if (has_lists) {
        builder->AddLine(WithoutLists(line, vertex, file, left.number()), file, left.number());
      } else {
        builder->AddLine(line, file, left.number());
      }
    }
  });
}

}  // namespace

Cloud ParsePly(std::string_view bytes, const std::string& file) {
  const PlyHeader header = ParsePlyHeader(bytes, file);
  const PlyElement& vertex = FindVertices(header, file);
  if (vertex.count == 0) return Cloud();
  Cloud cloud = header.encoding == PlyEncoding::kAscii ? ParseAscii(bytes, header, vertex, file)
                                                       : ParseBinary(bytes, header, vertex, file);
  if (header.viewpoint) cloud.viewpoint = *header.viewpoint;
  return cloud;
}

}  // namespace planegraph
