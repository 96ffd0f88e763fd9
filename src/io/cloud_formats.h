#pragma once

#include <istream>
#include <optional>
#include <string>
#include <string_view>

#include "planegraph/cloud/cloud.h"
#include "planegraph/io/cloud_writer.h"
#include "planegraph/io/labelled_cloud.h"

// The readers of one format each. They take a file's whole content; `file` is its name for
// messages. All throw InputError. The cloud may be empty where the data are (ReadCloud refuses
// that).

namespace planegraph {

/// The name of a cloud's format: what is asked for, or where that is "auto" by the ending, or else
/// by the first bytes. Throws InputError where the bytes are another format's, or none is known.
std::string ChooseCloudFormat(const std::string& path, const std::string& asked,
                              std::string_view bytes);

Cloud ParsePly(std::string_view bytes, const std::string& file);
/// The points of a merged map by their sources, read by blocks from the start of a stream that can
/// seek. Nothing where it is no whole map.ply as MapPlyWriter writes it.
std::optional<MergedMap> ParseMapPly(std::istream* stream, const std::string& file,
                                     std::size_t most = kEveryPoint);
/// A PLY with an int `plane` per point; nothing where it is another PLY or none.
std::optional<LabelledCloud> ParseLabelledPly(std::string_view bytes, const std::string& file);
Cloud ParsePcd(std::string_view bytes, const std::string& file);
/// XYZ, TXT, CSV: with the names of the columns in a first line, or told apart by their number.
Cloud ParseXyz(std::string_view bytes, const std::string& file);
/// 3DTK .3d text: left-handed centimetres, up to ten header lines.
Cloud Parse3dtkCloud(std::string_view bytes, const std::string& file);

/// The vector of a comment `KEY X Y Z`; nothing where the comment is another one. Throws InputError
/// (at `line`) where the key is right and the rest is not three finite numbers.
std::optional<Eigen::Vector3d> ParseVectorComment(std::string_view comment, std::string_view key,
                                                  const std::string& file, std::size_t line);
/// `X Y Z` in full digits.
std::string FormatVector(const Eigen::Vector3d& vector);

/// Throws InputError unless `count` records of `record_bytes` fit into what is left of a file of
/// `size` bytes from `position` on; says how many bytes are missing. Safe for any numbers.
void CheckRecordsFit(std::uint64_t size, std::size_t position, std::uint64_t count,
                     std::size_t record_bytes, const std::string& file);
inline void CheckRecordsFit(std::string_view bytes, std::size_t position, std::uint64_t count,
                            std::size_t record_bytes, const std::string& file) {
  CheckRecordsFit(bytes.size(), position, count, record_bytes, file);
}
/// The same for lines of text with `columns` numbers, which need at least 2 bytes each (the last
/// 1).
void CheckLinesFit(std::uint64_t size, std::size_t position, std::uint64_t count,
                   std::size_t columns, const std::string& file);

}  // namespace planegraph
