#include "io/cloud_formats.h"
#include "planegraph/io/cloud_writer.h"

namespace planegraph {
namespace {

constexpr std::size_t kBufferedPoints = 65536;

// The header has the same length for every count: the blanks at the end of a comment make up for
// the digits of the count, so it can be replaced when the count is known.
std::string HeaderOf(const Eigen::Vector3d& offset, std::uint64_t count) {
  constexpr std::size_t kLongestCount = 20;
  const std::string digits = std::to_string(count);
  return "ply\nformat binary_little_endian 1.0\ncomment offset " + FormatVector(offset) +
         "\ncomment source: 0 laser, 1 vision; scan and plane: -1 none" +
         std::string(kLongestCount - digits.size(), ' ') + "\nelement vertex " + digits +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\n"
         "property uchar source\nproperty int scan\nproperty int plane\nend_header\n";
}

}  // namespace

MapPlyWriter::MapPlyWriter(const std::string& path, const Eigen::Vector3d& offset)
    : file_(path), offset_(offset), buffer_(kBufferedPoints * kRecordBytes, '\0') {
  const std::string header = HeaderOf(offset_, 0);
  file_.Write(header.data(), header.size());
}

void MapPlyWriter::Flush() {
  file_.Write(buffer_.data(), filled_);
  flushed_ += filled_ / kRecordBytes;
  filled_ = 0;
}

void MapPlyWriter::Commit() {
  Flush();
  const std::string header = HeaderOf(offset_, flushed_);
  file_.stream().seekp(0);
  file_.Write(header.data(), header.size());
  file_.Commit();
}

}  // namespace planegraph
