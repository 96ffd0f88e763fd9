#pragma once

#include <memory>

#include "planegraph/correspondence/open_sky.h"
#include "planegraph/correspondence/scan_model.h"
#include "planegraph/correspondence/section_index.h"

namespace planegraph {

class DirectionGrid;

/// A drone map made ready for registration; built once. It refers to the plane set, which must
/// outlive it. Its frame is metric as far as the map's scale is known.
class MapModel {
 public:
  explicit MapModel(const PlaneSet& planes);

  const PlaneSet& planes() const { return *surfaces_.planes; }
  const PatchMap& surfaces() const { return surfaces_.map; }
  const std::vector<DirectionCluster>& directions() const { return surfaces_.directions; }
  const DirectionGrid& grid() const { return *grid_; }
  const OpenSky& sky() const { return sky_; }
  /// Surfels with their mean within `radius` metres of a place, in their order: a section of the
  /// map. The time is that of the section, whatever the size of the map.
  std::vector<std::uint32_t> Section(const Eigen::Vector3d& centre, double radius) const;

 private:
  ScanModel surfaces_;
  std::shared_ptr<const DirectionGrid> grid_;
  OpenSky sky_;
  SectionIndex sections_;
};

}  // namespace planegraph
