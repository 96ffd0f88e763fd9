#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "io/cloud_formats.h"
#include "io/text_scanner.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

constexpr std::size_t kBlock = 65536;  // points that are formatted at a time

void CheckLength(const std::string& path, const std::string& name, std::size_t length,
                 const Cloud& cloud) {
  if (length == cloud.size()) return;
  throw std::invalid_argument(path + ": '" + name + "' has " + std::to_string(length) +
                              " values for " + std::to_string(cloud.size()) + " points");
}

void CheckLengths(const std::string& path, const Cloud& cloud,
                  const std::vector<IntProperty>& properties) {
  if (!cloud.normals.empty()) CheckLength(path, "normals", cloud.normals.size(), cloud);
  if (!cloud.colors.empty()) CheckLength(path, "colors", cloud.colors.size(), cloud);
  if (!cloud.intensities.empty()) CheckLength(path, "intensities", cloud.intensities.size(), cloud);
  for (const IntProperty& p : properties) CheckLength(path, p.name, p.values.size(), cloud);
}

template <typename T>
void AppendBytes(std::string* block, const T* values, std::size_t count) {
  block->append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

// Formats points block by block, so that the file is never in memory as a whole.
template <typename AppendPoint>
void WriteBlocks(AtomicFile* file, std::size_t count, const AppendPoint& append) {
  std::string block;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    block.clear();
    const std::size_t end = std::min(count, begin + kBlock);
    for (std::size_t i = begin; i < end; ++i) append(&block, i);
    file->Write(block.data(), block.size());
  }
}

void WriteText(AtomicFile* file, const std::string& text) { file->Write(text.data(), text.size()); }

// ---- PLY ----

std::string PlyHeaderOf(const Cloud& cloud, const std::vector<IntProperty>& properties) {
  std::string h = "ply\nformat binary_little_endian 1.0\ncomment offset " +
                  FormatVector(cloud.offset) + "\ncomment viewpoint " +
                  FormatVector(cloud.viewpoint) + "\nelement vertex " +
                  std::to_string(cloud.size()) + "\n";
  for (const char* name : {"x", "y", "z"}) h += std::string("property float ") + name + "\n";
  if (!cloud.normals.empty()) {
    for (const char* name : {"nx", "ny", "nz"}) h += std::string("property float ") + name + "\n";
  }
  if (!cloud.colors.empty()) h += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!cloud.intensities.empty()) h += "property float intensity\n";
  for (const IntProperty& property : properties) h += "property int " + property.name + "\n";
  return h + "end_header\n";
}

void WritePly(AtomicFile* file, const Cloud& cloud, const std::vector<IntProperty>& properties) {
  WriteText(file, PlyHeaderOf(cloud, properties));
  WriteBlocks(file, cloud.size(), [&](std::string* block, std::size_t i) {
    AppendBytes(block, cloud.points[i].data(), 3);
    if (!cloud.normals.empty()) AppendBytes(block, cloud.normals[i].data(), 3);
    if (!cloud.colors.empty()) AppendBytes(block, cloud.colors[i].data(), 3);
    if (!cloud.intensities.empty()) AppendBytes(block, &cloud.intensities[i], 1);
    for (const IntProperty& property : properties) AppendBytes(block, &property.values[i], 1);
  });
}

// ---- PCD ----

std::string PcdHeaderOf(const Cloud& cloud, const std::vector<IntProperty>& properties) {
  std::string fields = "FIELDS x y z", sizes = "SIZE 4 4 4", types = "TYPE F F F",
              counts = "COUNT 1 1 1";
  const auto add = [&](const std::string& name, const char* type) {
    fields += " " + name;
    sizes += " 4";
    types += std::string(" ") + type;
    counts += " 1";
  };
  if (!cloud.normals.empty()) {
    for (const char* name : {"normal_x", "normal_y", "normal_z"}) add(name, "F");
  }
  if (!cloud.colors.empty()) add("rgb", "F");
  if (!cloud.intensities.empty()) add("intensity", "F");
  for (const IntProperty& property : properties) add(property.name, "I");
  const std::string count = std::to_string(cloud.size());
  return "# .PCD v0.7 - Point Cloud Data file format\n# offset " + FormatVector(cloud.offset) +
         "\nVERSION 0.7\n" + fields + "\n" + sizes + "\n" + types + "\n" + counts + "\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT " + FormatVector(cloud.viewpoint - cloud.offset) +
         " 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
}

// PCL keeps a colour as 0xRRGGBB in the bits of a float.
std::uint32_t PackColor(const std::array<std::uint8_t, 3>& color) {
  return static_cast<std::uint32_t>(color[0]) << 16 | static_cast<std::uint32_t>(color[1]) << 8 |
         color[2];
}

void WritePcd(AtomicFile* file, const Cloud& cloud, const std::vector<IntProperty>& properties) {
  WriteText(file, PcdHeaderOf(cloud, properties));
  WriteBlocks(file, cloud.size(), [&](std::string* block, std::size_t i) {
    AppendBytes(block, cloud.points[i].data(), 3);
    if (!cloud.normals.empty()) AppendBytes(block, cloud.normals[i].data(), 3);
    if (!cloud.colors.empty()) {
      const std::uint32_t packed = PackColor(cloud.colors[i]);
      AppendBytes(block, &packed, 1);
    }
    if (!cloud.intensities.empty()) AppendBytes(block, &cloud.intensities[i], 1);
    for (const IntProperty& property : properties) AppendBytes(block, &property.values[i], 1);
  });
}

// ---- XYZ ----

std::string XyzHeaderOf(const Cloud& cloud, const std::vector<IntProperty>& properties) {
  std::string header = "# offset " + FormatVector(cloud.offset) + "\n# viewpoint " +
                       FormatVector(cloud.viewpoint) + "\n# x y z";
  if (!cloud.normals.empty()) header += " nx ny nz";
  if (!cloud.colors.empty()) header += " red green blue";
  if (!cloud.intensities.empty()) header += " intensity";
  for (const IntProperty& property : properties) header += " " + property.name;
  return header + "\n";
}

template <typename T>
void AppendField(std::string* block, T value) {
  *block += ' ';
  AppendNumber(block, value);
}

void WriteXyz(AtomicFile* file, const Cloud& cloud, const std::vector<IntProperty>& properties) {
  WriteText(file, XyzHeaderOf(cloud, properties));
  WriteBlocks(file, cloud.size(), [&](std::string* block, std::size_t i) {
    AppendNumber(block, cloud.points[i].x());
    AppendField(block, cloud.points[i].y());
    AppendField(block, cloud.points[i].z());
    if (!cloud.normals.empty()) {
      for (int axis = 0; axis < 3; ++axis) AppendField(block, cloud.normals[i][axis]);
    }
    if (!cloud.colors.empty()) {
      for (const std::uint8_t channel : cloud.colors[i]) {
        AppendField(block, static_cast<long long>(channel));
      }
    }
    if (!cloud.intensities.empty()) AppendField(block, cloud.intensities[i]);
    for (const IntProperty& property : properties) {
      AppendField(block, static_cast<long long>(property.values[i]));
    }
    *block += '\n';
  });
}

// 3DTK's text: left-handed centimetres (x right, y up, z forward). It has no place for an offset.
void Write3dtk(AtomicFile* file, const Cloud& cloud,
               const std::vector<IntProperty>& /*properties*/) {
  WriteBlocks(file, cloud.size(), [&](std::string* block, std::size_t i) {
    const Eigen::Vector3d p = 100.0 * cloud.Position(i);
    AppendNumber(block, -p.y());
    AppendField(block, p.z());
    AppendField(block, p.x());
    if (!cloud.intensities.empty()) AppendField(block, cloud.intensities[i]);
    *block += '\n';
  });
}

}  // namespace

void WriteCloud(const std::string& path, const Cloud& cloud,
                const std::vector<IntProperty>& properties) {
  CheckLengths(path, cloud, properties);
  const std::string ending = ToLower(std::filesystem::path(path).extension().string());
  static const std::map<std::string, decltype(&WritePly)> kWriters = {{".ply", WritePly},
                                                                      {".pcd", WritePcd},
                                                                      {".xyz", WriteXyz},
                                                                      {".txt", WriteXyz},
                                                                      {".3d", Write3dtk}};
  const auto writer = kWriters.find(ending);
  if (writer == kWriters.end()) {
    throw InputError::InFile(path, "clouds are written as .ply, .pcd, .xyz, .txt or .3d");
  }
  AtomicFile file(path);
  writer->second(&file, cloud, properties);
  file.Commit();
}

}  // namespace planegraph
