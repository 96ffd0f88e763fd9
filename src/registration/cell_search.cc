#include "planegraph/registration/cell_search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "planegraph/base/parallel.h"
#include "planegraph/registration/xiao.h"

namespace planegraph {
namespace {

struct Cell {
  Eigen::Vector2d centre;
  Registration registration;
};

// Half the edge of a cell: the scan's reach by its planes, robustly, and the tolerance.
double HalfEdge(const PlaneSet& scan, double tolerance) {
  std::vector<double> reach;
  for (const PlaneSegment& plane : scan.planes) {
    for (const auto& corner : plane.hull) reach.push_back(corner.head<2>().norm());
  }
  if (reach.empty()) return tolerance;
  const auto high = reach.begin() + static_cast<std::ptrdiff_t>(0.9 * (reach.size() - 1));
  std::nth_element(reach.begin(), high, reach.end());
  return *high + tolerance;
}

// The planes of a cell with the cell's centre as their origin: the search bounds the translation.
PlaneSet CutCell(const PlaneSet& map, const Eigen::Vector2d& centre, double half,
                 const CellSearchOptions& options) {
  PlaneSet cell;
  cell.kind = map.kind;
  const Eigen::Vector3d shift(centre.x(), centre.y(), 0.0);
  for (const PlaneSegment& plane : map.planes) {
    const Eigen::Vector2d from_centre = plane.centroid().head<2>() - centre;
    if (from_centre.cwiseAbs().maxCoeff() > half || plane.area < options.min_area) continue;
    PlaneSegment moved = plane;
    moved.moments.mean -= shift;
    moved.plane.distance -= plane.plane.normal.dot(shift);
    moved.mask.origin -= shift;
    for (auto& corner : moved.hull) corner -= shift;
    cell.planes.push_back(std::move(moved));
  }
  std::stable_sort(cell.planes.begin(), cell.planes.end(),
                   [](const auto& a, const auto& b) { return a.area > b.area; });
  if (cell.planes.size() > options.most_planes) cell.planes.resize(options.most_planes);
  return cell;
}

std::vector<Cell> MakeCells(const PlaneSet& map, double step) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector2d high = -low;
  for (const PlaneSegment& plane : map.planes) {
    low = low.cwiseMin(plane.centroid().head<2>());
    high = high.cwiseMax(plane.centroid().head<2>());
  }
  std::vector<Cell> cells;
  for (double x = low.x(); x <= high.x(); x += step) {
    for (double y = low.y(); y <= high.y(); y += step) cells.push_back({{x, y}, {}});
  }
  return cells;
}

MapCandidate ToCandidate(const Cell& cell) {
  MapCandidate candidate;
  const Rigid3& pose = cell.registration.target_from_source();
  const Eigen::Vector3d shift(cell.centre.x(), cell.centre.y(), 0.0);
  candidate.refinement.map_from_group = Sim3(1.0, pose.rotation, pose.translation + shift);
  candidate.refinement.covariance.topLeftCorner<6, 6>() = cell.registration.refinement.covariance;
  candidate.evidence.agree = cell.registration.quality;
  return candidate;
}

void Decide(const CellSearchOptions& options, MapLocation* location) {
  char text[160];
  if (!(location->r1 > options.alpha)) {
    location->status = RegistrationStatus::kFailed;
    std::snprintf(text, sizeof(text), "the best cell's r is %.3f, not above alpha = %.3f",
                  location->r1, options.alpha);
  } else if (!(location->r1 > options.beta * location->r2)) {
    location->status = RegistrationStatus::kAmbiguous;
    std::snprintf(text, sizeof(text), "r is %.3f and %.3f in the two best cells (beta = %.2f)",
                  location->r1, location->r2, options.beta);
  } else {
    location->status = RegistrationStatus::kOk;
    return;
  }
  location->reason = text;
}

}  // namespace

MapLocation LocateByCells(const PlaneSet& map, const PlaneSet& scan,
                          const CellSearchOptions& options) {
  constexpr std::size_t kMostCandidates = 5;
  const double half = HalfEdge(scan, options.tolerance);
  std::vector<Cell> cells = MakeCells(map, std::max(1.0, 2.0 * half * options.step));
  XiaoOptions xiao;
  xiao.min_area = options.min_area;
  xiao.max_translation = 2.0 * half;
  ParallelFor(cells.size(), options.threads, [&](std::size_t k) {
    cells[k].registration = RegisterXiao(CutCell(map, cells[k].centre, half, options), scan, xiao);
  });
  std::stable_sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.registration.quality > b.registration.quality;
  });
  MapLocation location;
  for (const Cell& cell : cells) {
    if (location.candidates.size() == kMostCandidates || cell.registration.quality <= 0.0) break;
    location.candidates.push_back(ToCandidate(cell));
  }
  if (!cells.empty()) location.r1 = cells[0].registration.quality;
  if (cells.size() > 1) location.r2 = cells[1].registration.quality;
  Decide(options, &location);
  return location;
}

}  // namespace planegraph
