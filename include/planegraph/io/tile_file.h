#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "planegraph/cloud/cloud_tiles.h"

namespace planegraph {

/// Throws InputError where the folder's disk has less than `bytes` free; says nothing where that is
/// not known.
void CheckScratchRoom(const std::string& folder, std::uint64_t bytes);

/// A file without a name in a folder: it goes away with the program, however that ends. Reads and
/// writes by several threads at a time do not disturb each other.
class ScratchFile {
 public:
  /// Throws InputError where the folder does not take one.
  explicit ScratchFile(const std::string& folder);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  /// Throws InputError where the disk is full.
  void WriteAt(std::uint64_t place, const void* data, std::size_t bytes);
  /// Throws InputError, also where nothing was written.
  void ReadAt(std::uint64_t place, void* data, std::size_t bytes) const;

 private:
  std::string folder_;
  int file_ = -1;
};

/// A cloud by tiles on disk: points come in parts of any order and size, tiles go. Between them
/// `buffer` bytes at most are in memory, beside some hundred bytes for each tile. Positions,
/// normals and colours alone are kept.
class TileFile : public CloudTiles {
 public:
  /// What a point takes on disk, its label included.
  static std::size_t BytesOfPoint(bool has_normals, bool has_colors);

  /// `folder`: for the scratch file; `edge`: of a tile, metres; `buffer`: bytes.
  TileFile(const std::string& folder, double edge, std::size_t buffer);

  /// Adds points, all parts with the same offset and viewpoint and the same attributes. Throws
  /// InputError where the disk is full, std::invalid_argument where the parts differ,
  /// std::logic_error after Finish.
  void Add(const Cloud& part);
  /// After the last part, before anything else.
  void Finish();

  std::size_t count() const override { return tiles_.size(); }
  std::size_t PointsOf(std::size_t tile) const override { return tiles_[tile].points; }
  Cloud Load(std::size_t tile) const override;

  /// Keeps a number for each point of a tile, in its order; by several threads at a time.
  void WriteLabels(std::size_t tile, const std::vector<std::int32_t>& labels);
  std::vector<std::int32_t> ReadLabels(std::size_t tile) const;

  double edge() const { return edge_; }
  const Eigen::Vector3d& offset() const { return empty_.offset; }
  const Eigen::Vector3d& viewpoint() const { return empty_.viewpoint; }
  bool has_normals() const { return has_normals_; }

 private:
  struct Block {
    std::uint64_t place, bytes;
  };
  struct Tile {
    std::vector<Block> blocks;  // in the file, in order
    std::string waiting;        // records that are not yet
    std::size_t points = 0;
    std::uint64_t first_label = 0;
  };
  std::size_t RecordBytes() const;
  void Begin(const Cloud& part);
  void Flush();

  double edge_;
  std::size_t buffer_, waiting_ = 0;
  bool has_normals_ = false, has_colors_ = false, begun_ = false, finished_ = false;
  Cloud empty_;  // what the parts have in common
  std::map<TileKey, Tile> growing_;
  std::vector<Tile> tiles_;
  ScratchFile points_, labels_;
  std::uint64_t end_ = 0;
};

}  // namespace planegraph
