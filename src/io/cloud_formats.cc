#include "io/cloud_formats.h"

#include <cmath>
#include <limits>

#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {

std::optional<Eigen::Vector3d> ParseVectorComment(std::string_view comment, std::string_view key,
                                                  const std::string& file, std::size_t line) {
  const auto words = SplitWords(comment);
  if (words.empty() || words[0] != key) return std::nullopt;
  Eigen::Vector3d vector;
  bool good = words.size() == 4;
  for (int axis = 0; good && axis < 3; ++axis) {
    good = ParseNumber(words[static_cast<std::size_t>(axis) + 1], &vector[axis]);
  }
  if (!good || !vector.allFinite()) {
    throw InputError::AtLine(file, line, "'" + std::string(key) + "' needs three numbers");
  }
  return vector;
}

std::string FormatVector(const Eigen::Vector3d& vector) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) text += ' ';
    AppendNumber(&text, vector[axis]);
  }
  return text;
}

void CheckRecordsFit(std::uint64_t size, std::size_t position, std::uint64_t count,
                     std::size_t record_bytes, const std::string& file) {
  const std::uint64_t left = size - position;
  if (record_bytes == 0 || count <= left / record_bytes) return;
  const bool countable = count <= std::numeric_limits<std::uint64_t>::max() / record_bytes;
  const std::string missing =
      countable ? std::to_string(count * record_bytes - left) : std::string("more than 1e19");
  throw InputError::AtByte(file, size,
                           "the file ends " + missing + " bytes before its data (" +
                               std::to_string(count) + " records of " +
                               std::to_string(record_bytes) + " bytes)");
}

void CheckLinesFit(std::uint64_t size, std::size_t position, std::uint64_t count,
                   std::size_t columns, const std::string& file) {
  const std::uint64_t left = size - position;
  const std::size_t least = 2 * columns;
  if (columns == 0 || count <= (left + 1) / least) return;
  throw InputError::AtByte(file, size,
                           "the header promises " + std::to_string(count) + " points, and only " +
                               std::to_string(left) + " bytes follow");
}

}  // namespace planegraph
