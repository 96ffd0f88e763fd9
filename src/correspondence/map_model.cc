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
      sky_(surfaces_.map.surfels()),
      sections_(surfaces_.map.surfels()) {}

std::vector<std::uint32_t> MapModel::Section(const Eigen::Vector3d& centre, double radius) const {
  const auto& surfels = surfaces().surfels();
  std::vector<std::uint32_t> found = sections_.Near(centre, radius);
  std::erase_if(found, [&](std::uint32_t i) {
    return !((surfels[i].mean - centre).squaredNorm() <= radius * radius);
  });
  return found;
}

}  // namespace planegraph
