#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/cloud/voxel_key.h"
#include "planegraph/correspondence/patch_map.h"

namespace planegraph {

using Rgb = std::array<std::uint8_t, 3>;

/// Mean colours of a cloud by voxels: what is left of a drone's points once they are let go. Frame
/// and unit are the cloud's.
class VoxelColours {
 public:
  /// `voxel`: edge, metres.
  explicit VoxelColours(double voxel) : voxel_(voxel), slots_(1 << 12) {}
  VoxelColours(const Cloud& cloud, double voxel) : VoxelColours(voxel) { Add(cloud); }

  /// A cloud without colours leaves nothing.
  void Add(const Cloud& cloud);

  bool empty() const { return voxels_ == 0; }
  std::size_t voxels() const { return voxels_; }
  double voxel() const { return voxel_; }
  /// The mean colour of the voxel that the point is in; nothing where it holds no points.
  std::optional<Rgb> At(const Eigen::Vector3d& point) const;

 private:
  struct Slot {
    std::uint64_t key = kNoVoxel;
    std::uint32_t count = 0;
    std::array<std::uint32_t, 3> sum{};
  };
  Slot& SlotOf(std::uint64_t key);
  void Grow();

  double voxel_;
  std::size_t voxels_ = 0;
  std::vector<Slot> slots_;  // a power of two, at most half full
};

/// What laser scans can see of a drone map: balls about their places, in its metric frame.
class SeenParts {
 public:
  void Add(const Eigen::Vector3d& place, double reach) { balls_.emplace_back(place, reach); }
  /// Whether the place is within `slack` metres of one of them.
  bool Reach(const Eigen::Vector3d& place, double slack) const;

 private:
  std::vector<std::pair<Eigen::Vector3d, double>> balls_;
};

/// The colours that a drone map lends to laser points that lie on what it saw.
class MapColours {
 public:
  /// `gate`: metres along the normal that laser and map may be apart.
  MapColours(const PlaneSet& planes, double gate);
  /// For the laser points in `seen` alone, of which the others' colours may be any.
  MapColours(const PlaneSet& planes, double gate, SeenParts seen);

  /// The map's cloud, or parts of it, in the frame of the planes.
  void Add(const Cloud& cloud);
  bool empty() const { return voxels_.empty(); }
  /// Of a point on a plane with that normal: where the map has a surface that faces the same way,
  /// so that the underside of a roof does not get the colour of its top.
  std::optional<Rgb> OnPlane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  /// Of a point of no plane.
  std::optional<Rgb> At(const Eigen::Vector3d& point) const { return voxels_.At(point); }

 private:
  VoxelColours voxels_;
  PatchMap surfaces_;
  double gate_;
  std::optional<SeenParts> seen_;
};

}  // namespace planegraph
