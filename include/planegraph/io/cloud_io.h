#pragma once

#include <string>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// The endings of the cloud formats that are read, for messages: ".ply .pcd ...".
std::string CloudEndings();

/// Of a file by its ending: "ply", "pcd", "xyz" or "3dtk"; "" of all others.
std::string CloudFormatOfEnding(const std::string& path);

/// Reads a cloud: PLY (ascii, binary little and big endian, float or double), PCD (ascii, binary,
/// binary_compressed), XYZ/TXT/CSV, 3DTK `.3d`. `format` is "auto" (by the ending, checked against
/// the content), "ply", "pcd", "xyz" or "3dtk". Points with a NaN or infinite coordinate are
/// dropped. 3DTK clouds come right-handed in metres (x forward, y left, z up). Throws InputError.
Cloud ReadCloud(const std::string& path, const std::string& format = "auto");

/// The same cloud without normals, colours and intensities. Where `format` is "ply" and the file is
/// one that WriteCloud or MapPlyWriter wrote, no more of it than a block is in memory at a time.
Cloud ReadPositions(const std::string& path, const std::string& format = "auto");

/// An additional integer property per point, for example the plane's id.
struct IntProperty {
  std::string name;
  std::vector<std::int32_t> values;
};

/// Writes a cloud by the ending of `path` (.ply binary little endian, .pcd binary, .xyz and .txt
/// text with the names of the columns, .3d 3DTK text), atomically. The offset is written as the
/// comment `offset X Y Z` and the points as floats beside it, so all but .3d read back bit for bit;
/// .3d holds whole positions and intensities alone. Throws InputError; std::invalid_argument where
/// the attributes' lengths differ.
void WriteCloud(const std::string& path, const Cloud& cloud,
                const std::vector<IntProperty>& properties = {});

}  // namespace planegraph
