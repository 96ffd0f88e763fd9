#include "planegraph/correspondence/map_model.h"

#include "correspondence/direction_grid.h"

namespace planegraph {
namespace {

// Coarse enough for a rotation that is off by some degrees at the end of a scan, fine enough to
// tell one street from the next.
constexpr double kVoxel = 0.8;  // metres

}  // namespace

MapModel::MapModel(const PlaneSet& planes)
    : surfaces_(planes),
      grid_(std::make_shared<const DirectionGrid>(surfaces_.map.surfels(), kVoxel)),
      sky_(surfaces_.map.surfels()) {}

std::vector<std::uint32_t> MapModel::Section(const Eigen::Vector3d& centre, double radius) const {
  std::vector<std::uint32_t> found;
  const auto& surfels = surfaces().surfels();
  for (std::uint32_t i = 0; i < surfels.size(); ++i) {
    if ((surfels[i].mean - centre).squaredNorm() <= radius * radius) found.push_back(i);
  }
  return found;
}

}  // namespace planegraph
