#pragma once

#include <string>
#include <vector>

#include "planegraph/pipeline/front_end.h"
#include "planegraph/pipeline/map_front_end.h"
#include "planegraph/pipeline/site.h"

namespace planegraph {

/// A site whose scans are looked for in its first drone map, with the truth.
struct LocatedSite {
  std::string name;  ///< as given on the command line
  Site site;
  MapRecord map;                        ///< scale by GPS alone
  Sim3 world_from_map;                  ///< truth: similarity.json
  std::vector<ScanRecord> scans;        ///< of all robots
  std::vector<Rigid3> world_from_scan;  ///< truth, by scan
  /// By scan: share of its 0.25 m voxels with a point of the map within 0.15 m, at the true pose.
  std::vector<double> coverage;

  bool Covered(std::size_t scan) const { return coverage[scan] >= 0.5; }
  /// Truth: the map's metric frame (by GPS) from the scan.
  Sim3 MetricFromScan(std::size_t scan) const;
};

/// Reads SITE.yaml, or a folder's site file that gives no start pose, and
/// truth/similarity.json beside it. Throws InputError.
LocatedSite ReadLocatedSite(const std::string& path, int threads);

}  // namespace planegraph
