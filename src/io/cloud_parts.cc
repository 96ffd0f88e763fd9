#include "planegraph/io/cloud_parts.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "io/cloud_formats.h"
#include "io/cloud_layout.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr std::size_t kHeaderBytes = 1 << 20;  // at most
constexpr std::size_t kLongestLine = 1 << 20;  // of text
constexpr std::size_t kLargestPart = 1 << 16;  // points, where none are asked for

// Whether a line of the text, which may be cut, begins with the word.
bool HasLine(std::string_view text, std::string_view word) {
  LineReader lines(text);
  std::string_view line;
  while (lines.Next(&line) && lines.position() < text.size()) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.starts_with(word)) return true;
  }
  return false;
}

// The layout of the file's points where they can be read in parts.
std::optional<CloudLayout> LayoutOfFile(std::ifstream* stream, std::uint64_t size,
                                        const std::string& path) {
  std::string start(std::min<std::uint64_t>(size, kHeaderBytes), '\0');
  stream->read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream->gcount()));
  stream->clear();
  if (start.empty()) return {};
  const std::string format = ChooseCloudFormat(path, "auto", start);
  if (format != "ply" && format != "pcd") return {};
  const bool is_cut = start.size() < size;
  if (is_cut && !HasLine(start, format == "ply" ? "end_header" : "DATA")) return {};
  return format == "ply" ? LayoutOf(ParsePlyHeader(start, path), size, path)
                         : LayoutOf(ParsePcdHeader(start, path), size, path);
}

struct OpenFile {
  std::ifstream stream;
  CloudExtent extent;
  std::optional<CloudLayout> layout;

  explicit OpenFile(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return;
    stream.open(path, std::ios::binary);
    extent.bytes = std::filesystem::file_size(path, error);
    if (!stream || error) {
      throw InputError::InFile(path, std::string("cannot be read: ") + std::strerror(errno));
    }
    layout = LayoutOfFile(&stream, extent.bytes, path);
    if (layout) extent.points = layout->count;
  }
};

// Float coordinates keep their place: only doubles, and numbers as text, are moved.
bool MayNeedOffset(const CloudLayout& layout) {
  if (layout.offset) return false;
  if (layout.is_text) return true;
  return std::any_of(layout.fields.begin(), layout.fields.end(), [](const auto& field) {
    return field.role <= Role::kZ && field.type != ScalarType::kFloat32;
  });
}

}  // namespace

class CloudParts::Impl {
 public:
  Impl(const std::string& path, std::size_t most, Offset offset, std::size_t block)
      : path_(path), most_(most), block_bytes_(block), file_(path) {
    if (!file_.layout) throw std::invalid_argument(path + " cannot be read in parts");
    Rewind();
    if (MayNeedOffset(layout()) && offset == Offset::kAtOnce) FindShift();
  }

  const CloudExtent& extent() const { return file_.extent; }
  bool OffsetCameLate() const { return came_late_; }

  bool Next(Cloud* part) { return Next(most_, part); }

  void Rewind() {
    file_.stream.clear();
    file_.stream.seekg(static_cast<std::streamoff>(layout().body));
    have_ = 0;
    came_late_ = false;
    block_.clear();
    at_ = end_ = 0;
    line_ = layout().lines;
  }

 private:
  const CloudLayout& layout() const { return *file_.layout; }

  bool Next(std::size_t most, Cloud* part) {
    if (have_ >= layout().count) return false;
    const bool is_first = have_ == 0;
    *part = layout().is_text ? NextLines(most) : NextRecords(most);
    part->viewpoint = layout().viewpoint;
    if (!shift_ && !layout().offset && !part->offset.isZero()) {
      shift_ = part->offset;
      came_late_ = !is_first;
    }
    return true;
  }

  void FindShift() {
    Cloud part;
    while (!shift_ && Next(std::max(most_, kLargestPart), &part)) continue;
    if (!shift_) shift_ = Eigen::Vector3d::Zero();
    Rewind();
  }

  Cloud NextRecords(std::size_t most) {
    const std::size_t count = std::min<std::uint64_t>(most, layout().count - have_);
    block_.resize(count * layout().stride);
    if (!file_.stream.read(block_.data(), static_cast<std::streamsize>(block_.size()))) {
      throw InputError::InFile(path_, "the file ends too early");
    }
    have_ += count;
    PointColumns columns = layout().ColumnsAt(block_.data(), count);
    columns.shift = shift_;
    return AssembleCloud(columns);
  }

  Cloud NextLines(std::size_t most) {
    TextColumns text = layout().text;
    text.shift = shift_;
    CloudBuilder builder(text);
    const std::uint64_t last = std::min<std::uint64_t>(have_ + most, layout().count);
    while (have_ < last) {
      if (at_ == end_) ReadBlock();
      LineReader lines(std::string_view(block_).substr(at_, end_ - at_), line_ + 1);
      std::string_view line;
      while (have_ < last && lines.Next(&line)) {
        line_ = lines.number();
        if (Trim(line).empty()) continue;
        builder.AddLine(line, path_, line_);
        ++have_;
      }
      at_ += lines.position();
    }
    return builder.Take();
  }

  // Whole lines, from at_ to end_; the start of the next one waits behind them.
  void ReadBlock() {
    block_.erase(0, at_);
    at_ = end_ = 0;
    while (end_ == 0 && block_.size() <= kLongestLine) {
      const std::size_t before = block_.size();
      block_.resize(before + block_bytes_);
      file_.stream.read(&block_[before], static_cast<std::streamsize>(block_bytes_));
      block_.resize(before + static_cast<std::size_t>(file_.stream.gcount()));
      if (block_.empty()) FailAtEnd();
      if (block_.size() == before) end_ = before;  // the last line needs no line feed
      const std::size_t feed = std::string_view(block_).substr(before).rfind('\n');
      if (feed != std::string_view::npos) end_ = before + feed + 1;
    }
    if (end_ == 0) throw InputError::AtLine(path_, line_ + 1, "the line is longer than 1 MB");
  }

  [[noreturn]] void FailAtEnd() const {
    throw InputError::AtLine(path_, line_,
                             "the file ends after " + std::to_string(have_) + " of " +
                                 std::to_string(layout().count) + " " + layout().lines_are);
  }

  std::string path_;
  std::size_t most_, block_bytes_;
  OpenFile file_;
  std::optional<Eigen::Vector3d> shift_;
  bool came_late_ = false;
  std::uint64_t have_ = 0;  // points, also those that are not finite
  std::size_t line_ = 0;    // the last that was read
  std::string block_;
  std::size_t at_ = 0, end_ = 0;  // of the block's lines that were not taken
};

std::optional<CloudExtent> CloudParts::Measure(const std::string& path) {
  const OpenFile file(path);
  if (!file.layout) return {};
  return file.extent;
}

CloudParts::CloudParts(const std::string& path, std::size_t most, Offset offset, std::size_t block)
    : impl_(std::make_unique<Impl>(path, most, offset, block)) {}
CloudParts::~CloudParts() = default;
CloudParts::CloudParts(CloudParts&&) noexcept = default;
CloudParts& CloudParts::operator=(CloudParts&&) noexcept = default;

const CloudExtent& CloudParts::extent() const { return impl_->extent(); }
bool CloudParts::Next(Cloud* part) { return impl_->Next(part); }
void CloudParts::Rewind() { impl_->Rewind(); }
bool CloudParts::OffsetCameLate() const { return impl_->OffsetCameLate(); }

}  // namespace planegraph
