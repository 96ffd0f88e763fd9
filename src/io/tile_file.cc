#include "planegraph/io/tile_file.h"

#include <cstring>
#include <optional>
#include <stdexcept>

namespace planegraph {
namespace {

constexpr std::size_t kVector = 3 * sizeof(float), kColor = 3;

template <typename T>
void Append(const T* from, std::size_t bytes, std::string* to) {
  to->append(reinterpret_cast<const char*>(from), bytes);
}

const char* Take(const char* from, std::size_t bytes, void* to) {
  std::memcpy(to, from, bytes);
  return from + bytes;
}

}  // namespace

TileFile::TileFile(const std::string& folder, double edge, std::size_t buffer)
    : edge_(edge), buffer_(buffer), points_(folder), labels_(folder) {}

std::size_t TileFile::BytesOfPoint(bool has_normals, bool has_colors) {
  return kVector + (has_normals ? kVector : 0) + (has_colors ? kColor : 0) + sizeof(std::int32_t);
}

std::size_t TileFile::RecordBytes() const {
  return BytesOfPoint(has_normals_, has_colors_) - sizeof(std::int32_t);
}

void TileFile::Begin(const Cloud& part) {
  if (finished_) throw std::logic_error("the tiles are finished");
  if (part.size() == 0) return;
  const bool normals = !part.normals.empty(), colors = !part.colors.empty();
  if (begun_ && (normals != has_normals_ || colors != has_colors_ || part.offset != empty_.offset ||
                 part.viewpoint != empty_.viewpoint)) {
    throw std::invalid_argument("the parts of a cloud differ");
  }
  begun_ = true;
  has_normals_ = normals, has_colors_ = colors;
  empty_.offset = part.offset;
  empty_.viewpoint = part.viewpoint;
}

void TileFile::Add(const Cloud& part) {
  Begin(part);
  std::optional<TileKey> last;
  Tile* in = nullptr;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const TileKey key = TileOf(part.points[i], edge_);
    if (key != last) in = &growing_[key];  // neighbours in a file are mostly so in space
    last = key;
    Tile& tile = *in;
    Append(part.points[i].data(), kVector, &tile.waiting);
    if (has_normals_) Append(part.normals[i].data(), kVector, &tile.waiting);
    if (has_colors_) Append(part.colors[i].data(), kColor, &tile.waiting);
    ++tile.points;
    waiting_ += RecordBytes();
    // A string may hold room for twice its length.
    if (2 * waiting_ > buffer_) Flush();
  }
}

void TileFile::Flush() {
  for (auto& [key, tile] : growing_) {
    if (tile.waiting.empty()) continue;
    points_.WriteAt(end_, tile.waiting.data(), tile.waiting.size());
    tile.blocks.push_back({end_, tile.waiting.size()});
    end_ += tile.waiting.size();
    std::string().swap(tile.waiting);
  }
  waiting_ = 0;
}

void TileFile::Finish() {
  finished_ = true;
  Flush();
  std::uint64_t labels = 0;
  for (auto& [key, tile] : growing_) {
    tile.first_label = labels;
    labels += tile.points;
    tiles_.push_back(std::move(tile));
  }
  growing_.clear();
}

Cloud TileFile::Load(std::size_t index) const {
  const Tile& tile = tiles_[index];
  Cloud cloud = empty_;
  cloud.points.reserve(tile.points);
  if (has_normals_) cloud.normals.reserve(tile.points);
  if (has_colors_) cloud.colors.reserve(tile.points);
  std::string bytes;
  for (const Block& block : tile.blocks) {
    bytes.resize(block.bytes);
    points_.ReadAt(block.place, bytes.data(), bytes.size());
    const char* end = bytes.data() + bytes.size();
    for (const char* at = bytes.data(); at != end;) {
      at = Take(at, kVector, cloud.points.emplace_back().data());
      if (has_normals_) at = Take(at, kVector, cloud.normals.emplace_back().data());
      if (has_colors_) at = Take(at, kColor, cloud.colors.emplace_back().data());
    }
  }
  return cloud;
}

void TileFile::WriteLabels(std::size_t tile, const std::vector<std::int32_t>& labels) {
  if (labels.size() != tiles_[tile].points) {
    throw std::invalid_argument("a tile needs one label for each point");
  }
  labels_.WriteAt(4 * tiles_[tile].first_label, labels.data(), 4 * labels.size());
}

std::vector<std::int32_t> TileFile::ReadLabels(std::size_t tile) const {
  std::vector<std::int32_t> labels(tiles_[tile].points);
  labels_.ReadAt(4 * tiles_[tile].first_label, labels.data(), 4 * labels.size());
  return labels;
}

}  // namespace planegraph
