#pragma once

#include "planegraph/registration/map_registration.h"

namespace planegraph {

/// The paper's search for the initial pose, for comparison (Surmann, Berninger and Worst, after
/// Schmiedel et al.).
struct CellSearchOptions {
  double tolerance = 5.0;        ///< metres: a cell is the scan's size and this on each side
  double step = 0.5;             ///< distance of two cells, in cells
  double alpha = 0.1;            ///< least r of the best cell
  double beta = 1.2;             ///< and this many times the second best's
  double min_area = 2.0;         ///< m^2: smaller planes take no part
  std::size_t most_planes = 60;  ///< of a cell, the largest: the search is cubic
  int threads = 1;
};

/// Divides the map into cells, registers the scan with each by Xiao's search, and takes the cell
/// with the largest share of matched planes, r = |K| / max(|P_map|, |P_scan|), if r1 > alpha and r1
/// > beta r2. As in the paper r2 is that of the second best cell, whatever pose it found.
/// Candidates carry r as their evidence's `agree` (and no more evidence).
MapLocation LocateByCells(const PlaneSet& map, const PlaneSet& scan,
                          const CellSearchOptions& options = {});

}  // namespace planegraph
