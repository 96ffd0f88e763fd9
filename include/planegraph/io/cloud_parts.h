#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// A cloud's file, read in parts, so that no more of it than a part is in memory: PLY (ascii and
/// binary) and PCD (ascii and binary). The parts one after the other are what ReadCloud gives, all
/// with its offset and viewpoint.
class CloudParts {
 public:
  /// Whether the file can be read in parts: not compressed, no lists among the properties of its
  /// points or before them, no pipe. Throws InputError where the header is wrong, promises more
  /// points than there are bytes for, or the file cannot be read.
  static bool CanRead(const std::string& path);

  /// `most`: points of a part. Throws InputError as CanRead, std::invalid_argument where that says
  /// no.
  explicit CloudParts(const std::string& path, std::size_t most = 65536);
  ~CloudParts();
  CloudParts(CloudParts&&) noexcept;
  CloudParts& operator=(CloudParts&&) noexcept;

  /// Points that the header promises; those that are not finite are dropped on the way.
  std::uint64_t promised() const;
  /// Bytes of the file.
  std::uint64_t bytes() const;
  /// The next part (which may be empty); false behind the last. Throws InputError.
  bool Next(Cloud* part);
  /// Begins again.
  void Rewind();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planegraph
