#include "planegraph/io/cloud_parts.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "io/cloud_layout.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr std::size_t kHeaderBytes = 1 << 20;  // at most
constexpr std::size_t kTextBlock = 1 << 20;

// The layout of the file's points where they can be read in parts.
std::optional<CloudLayout> LayoutOfFile(std::ifstream* stream, std::uint64_t size,
                                        const std::string& path) {
  std::string start(std::min<std::uint64_t>(size, kHeaderBytes), '\0');
  stream->read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream->gcount()));
  stream->clear();
  const std::string_view word = std::string_view(start).substr(0, start.find_first_of(" \r\n"));
  if (word == "ply") return LayoutOf(ParsePlyHeader(start, path), size, path);
  if (start.starts_with("# .PCD") || word == "VERSION") {
    return LayoutOf(ParsePcdHeader(start, path), size, path);
  }
  return {};
}

struct OpenFile {
  std::ifstream stream;
  std::uint64_t size = 0;
  std::optional<CloudLayout> layout;

  explicit OpenFile(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return;
    stream.open(path, std::ios::binary);
    size = std::filesystem::file_size(path, error);
    if (!stream || error) {
      throw InputError::InFile(path, std::string("cannot be read: ") + std::strerror(errno));
    }
    layout = LayoutOfFile(&stream, size, path);
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
  Impl(const std::string& path, std::size_t most) : path_(path), most_(most), file_(path) {
    if (!file_.layout) throw std::invalid_argument(path + " cannot be read in parts");
    Rewind();
    if (MayNeedOffset(layout())) FindShift();
  }

  const CloudLayout& layout() const { return *file_.layout; }
  std::uint64_t size() const { return file_.size; }

  bool Next(Cloud* part) {
    if (have_ >= layout().count) return false;
    *part = layout().is_text ? NextLines() : NextRecords();
    part->viewpoint = layout().viewpoint;
    return true;
  }

  void Rewind() {
    file_.stream.clear();
    file_.stream.seekg(static_cast<std::streamoff>(layout().body));
    have_ = 0;
    block_.clear();
    line_ = layout().lines;
  }

 private:
  void FindShift() {
    Cloud part;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    while (shift.isZero() && Next(&part)) shift = part.offset;
    shift_ = shift;
    Rewind();
  }

  Cloud NextRecords() {
    const std::size_t count = std::min<std::uint64_t>(most_, layout().count - have_);
    block_.resize(count * layout().stride);
    if (!file_.stream.read(block_.data(), static_cast<std::streamsize>(block_.size()))) {
      throw InputError::InFile(path_, "the file ends too early");
    }
    have_ += count;
    PointColumns columns = layout().ColumnsAt(block_.data(), count);
    columns.shift = shift_;
    return AssembleCloud(columns);
  }

  // Lines are taken from a block that begins with one and ends, but for the file's last, with one.
  Cloud NextLines() {
    TextColumns text = layout().text;
    text.shift = shift_;
    CloudBuilder builder(text);
    const std::uint64_t last = std::min<std::uint64_t>(have_ + most_, layout().count);
    while (have_ < last) {
      if (block_.empty()) ReadBlock();
      LineReader lines(block_, line_ + 1);
      std::string_view line;
      while (have_ < last && lines.Next(&line)) {
        line_ = lines.number();
        if (Trim(line).empty()) continue;
        builder.AddLine(line, path_, line_);
        ++have_;
      }
      block_.erase(0, lines.position());
    }
    return builder.Take();
  }

  void ReadBlock() {
    std::string rest;
    block_.resize(kTextBlock);
    file_.stream.read(block_.data(), static_cast<std::streamsize>(block_.size()));
    block_.resize(static_cast<std::size_t>(file_.stream.gcount()));
    if (block_.empty()) {
      throw InputError::AtLine(path_, line_,
                               "the file ends after " + std::to_string(have_) + " of " +
                                   std::to_string(layout().count) + " points");
    }
    if (block_.back() != '\n' && std::getline(file_.stream, rest)) block_ += rest + '\n';
  }

  std::string path_;
  std::size_t most_;
  OpenFile file_;
  std::optional<Eigen::Vector3d> shift_;
  std::uint64_t have_ = 0;  // points, also those that are not finite
  std::size_t line_ = 0;    // the last that was read
  std::string block_;
};

bool CloudParts::CanRead(const std::string& path) { return OpenFile(path).layout.has_value(); }

CloudParts::CloudParts(const std::string& path, std::size_t most)
    : impl_(std::make_unique<Impl>(path, most)) {}
CloudParts::~CloudParts() = default;
CloudParts::CloudParts(CloudParts&&) noexcept = default;
CloudParts& CloudParts::operator=(CloudParts&&) noexcept = default;

std::uint64_t CloudParts::promised() const { return impl_->layout().count; }
std::uint64_t CloudParts::bytes() const { return impl_->size(); }
bool CloudParts::Next(Cloud* part) { return impl_->Next(part); }
void CloudParts::Rewind() { impl_->Rewind(); }

}  // namespace planegraph
