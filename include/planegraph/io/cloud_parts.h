#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// What a cloud's header says of its size.
struct CloudExtent {
  std::uint64_t points = 0;  ///< promised; those that are not finite are dropped on the way
  std::uint64_t bytes = 0;   ///< of the file
};

/// A cloud's file, read in parts, so that no more of it than a part is in memory: PLY (ascii and
/// binary) and PCD (ascii and binary). The parts one after the other are what ReadCloud gives, all
/// with its offset and viewpoint.
class CloudParts {
 public:
  /// When it is known whether a cloud needs an offset, which its first point beyond 10 km gives.
  enum class Offset {
    kAtOnce,   ///< The file is read up to that point, or its end, before the first part.
    kOnTheWay  ///< On the first way the parts before that point have none: see OffsetCameLate.
  };

  /// The header's promise; reads nothing else. Nothing where the file cannot be read in parts:
  /// another format, compressed, lists among the properties of its points or before them, a header
  /// of more than 1 MB, a pipe. Throws InputError where the header is wrong, promises more points
  /// than there are bytes for, or the file cannot be read.
  static std::optional<CloudExtent> Measure(const std::string& path);
  static bool CanRead(const std::string& path) { return Measure(path).has_value(); }

  /// `most`: points of a part; `block`: bytes of text that are read at a time. Throws InputError as
  /// Measure, std::invalid_argument where that gives nothing.
  explicit CloudParts(const std::string& path, std::size_t most = 65536,
                      Offset offset = Offset::kAtOnce, std::size_t block = 1 << 20);
  ~CloudParts();
  CloudParts(CloudParts&&) noexcept;
  CloudParts& operator=(CloudParts&&) noexcept;

  const CloudExtent& extent() const;
  /// The next part (which may be empty); false behind the last. Throws InputError.
  bool Next(Cloud* part);
  /// Begins again.
  void Rewind();
  /// Whether parts since the beginning lack the offset of those behind them; Rewind mends it.
  bool OffsetCameLate() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planegraph
