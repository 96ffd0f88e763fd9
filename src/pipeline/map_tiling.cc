#include "planegraph/pipeline/map_tiling.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "planegraph/base/disjoint_sets.h"
#include "planegraph/base/error.h"
#include "planegraph/geometry/alignment.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix37 = Eigen::Matrix<double, 3, 7>;

// How a place moves by the perturbation of the similarity that takes it to the world.
Matrix37 MotionOf(const Sim3& world_from_metric, const Vector3d& place) {
  const Vector3d arm = world_from_metric.scale * (world_from_metric.rotation * place);
  Matrix37 motion;
  motion << Eigen::Matrix3d::Identity(), -Hat(arm), arm;
  return motion;
}

}  // namespace

MapGrid::MapGrid(const MapTiling& tiling, const PlaneSet& planes, const Sim3& world_from_metric,
                 const std::string& file)
    : tiling_(tiling), world_from_metric_(world_from_metric) {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Patch& patch : planes.patches) {
    const Vector2d at = (world_from_metric * patch.moments.mean).head<2>();
    low = low.cwiseMin(at), high = high.cwiseMax(at);
  }
  if (planes.patches.empty()) low = high = world_from_metric.translation.head<2>();
  const Vector2d cells = ((high - low) / tiling.size).array().floor() + 1.0;
  low_ = 0.5 * (low + high - tiling.size * cells);
  FindTiles(planes, file);
  TieNeighbours();
  TieAcrossGaps();
}

Vector2d MapGrid::InCells(const Vector3d& place) const {
  return ((world_from_metric_ * place).head<2>() - low_) / tiling_.size;
}

void MapGrid::FindTiles(const PlaneSet& planes, const std::string& file) {
  std::map<Cell, std::pair<double, double>> heights;  // sum, count
  for (const Patch& patch : planes.patches) {
    const Eigen::Vector2i cell = InCells(patch.moments.mean).array().floor().cast<int>();
    auto& [sum, count] = heights[{cell.x(), cell.y()}];
    sum += (world_from_metric_ * patch.moments.mean).z(), count += 1.0;
  }
  if (heights.empty()) heights[{0, 0}] = {world_from_metric_.translation.z(), 1.0};
  if (heights.size() > kMostTiles) {
    char text[120];
    std::snprintf(text, sizeof(text), "tiles of %g m would be %zu, at most %zu are possible",
                  tiling_.size, heights.size(), kMostTiles);
    throw InputError::InFile(file, text);
  }
  for (const auto& [cell, height] : heights) {
    const Vector2d middle =
        low_ + tiling_.size * (Vector2d(cell.first, cell.second) + Vector2d(0.5, 0.5));
    tiles_[cell] = static_cast<int>(cells_.size());
    cells_.push_back(cell);
    middles_.push_back(world_from_metric_.Inverse() *
                       Vector3d(middle.x(), middle.y(), height.first / height.second));
  }
}

void MapGrid::AddTie(int target, int source) {
  const double distance = world_from_metric_.scale * (middles_[target] - middles_[source]).norm();
  ties_.push_back({target, source, 0.5 * (middles_[target] + middles_[source]), distance});
}

void MapGrid::TieNeighbours() {
  for (int t = 0; t < static_cast<int>(cells_.size()); ++t) {
    for (const Cell& step : {Cell(1, 0), Cell(0, 1)}) {
      const auto next = tiles_.find({cells_[t].first + step.first, cells_[t].second + step.second});
      if (next != tiles_.end()) AddTie(t, next->second);
    }
  }
}

// The parts that share no border, by the shortest ways between them.
void MapGrid::TieAcrossGaps() {
  DisjointSets parts(count());
  for (const Tie& tie : ties_) parts.Join(tie.target, tie.source);
  std::vector<std::pair<double, std::pair<int, int>>> ways;
  for (int a = 0; a < static_cast<int>(count()); ++a) {
    for (int b = a + 1; b < static_cast<int>(count()); ++b) {
      if (parts.Find(a) == parts.Find(b)) continue;
      ways.push_back({(middles_[a] - middles_[b]).squaredNorm(), {a, b}});
    }
  }
  std::sort(ways.begin(), ways.end());
  for (const auto& [length, way] : ways) {
    if (parts.Find(way.first) == parts.Find(way.second)) continue;
    parts.Join(way.first, way.second);
    AddTie(way.first, way.second);
  }
}

int MapGrid::Nearest(const Cell& cell) const {
  const auto off = [&](const Cell& other) {
    return std::hypot(other.first - cell.first, other.second - cell.second);
  };
  const auto nearest = std::min_element(
      cells_.begin(), cells_.end(), [&](const Cell& a, const Cell& b) { return off(a) < off(b); });
  return static_cast<int>(nearest - cells_.begin());
}

int MapGrid::TileOfCell(const Cell& cell) const {
  const auto found = tiles_.find(cell);
  return found != tiles_.end() ? found->second : Nearest(cell);
}

int MapGrid::TileAt(const Vector3d& place) const {
  const Eigen::Vector2i cell = InCells(place).array().floor().cast<int>();
  return TileOfCell({cell.x(), cell.y()});
}

MapGrid::Blend MapGrid::At(const Vector3d& place) const {
  const Vector2d at = InCells(place) - Vector2d(0.5, 0.5);
  const Vector2d base = at.array().floor(), share = at - base;
  Blend blend;
  for (int k = 0; k < 4; ++k) {
    const int x = k % 2, y = k / 2;
    const double weight =
        (x == 1 ? share.x() : 1.0 - share.x()) * (y == 1 ? share.y() : 1.0 - share.y());
    if (!(weight > 0.0)) continue;
    const int tile = TileOfCell({static_cast<int>(base.x()) + x, static_cast<int>(base.y()) + y});
    const auto same = std::find_if(blend.begin(), blend.end(),
                                   [&](const auto& entry) { return entry.first == tile; });
    if (same != blend.end()) {
      same->second += weight;
    } else {
      blend.push_back({tile, weight});
    }
  }
  return blend;
}

double SigmaOfPlace(const Matrix7d& covariance, const Sim3& world_from_metric,
                    const Vector3d& place) {
  if (!covariance.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  const Matrix37 motion = MotionOf(world_from_metric, place);
  const Eigen::Matrix3d variance = motion * covariance * motion.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(variance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

Vector3d BentMap::operator*(const Vector3d& place) const {
  Vector3d mean = Vector3d::Zero();
  for (const auto& [tile, weight] : grid->At(place)) {
    mean += weight * (world_from_tile[tile] * place);
  }
  return mean;
}

BendingFit FitBentMap(const BentMap& map, const PlaneSet& planes) {
  BendingFit fit{map.world_from_tile.front()};
  std::vector<Vector3d> places, bent;
  for (const Patch& patch : planes.patches) {
    places.push_back(patch.moments.mean);
    bent.push_back(map * patch.moments.mean);
  }
  if (places.empty()) return fit;
  const Alignment aligned = AlignPoints(places, bent, true);
  if (aligned.rank < 2) return fit;
  fit.world_from_metric = aligned.target_from_source;
  double sum = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double off = (fit.world_from_metric * places[i] - bent[i]).norm();
    sum += off * off;
    fit.largest = std::max(fit.largest, off);
  }
  fit.rms = std::sqrt(sum / static_cast<double>(places.size()));
  return fit;
}

std::vector<Matrix7d> FitByTiles(const BentMap& map, const BendingFit& fit,
                                 const PlaneSet& planes) {
  Matrix7d all = Matrix7d::Zero();
  std::vector<Matrix7d> by_tile(map.grid->count(), Matrix7d::Zero());
  for (const Patch& patch : planes.patches) {
    const Matrix37 own = MotionOf(fit.world_from_metric, patch.moments.mean);
    all += own.transpose() * own;
    for (const auto& [tile, weight] : map.grid->At(patch.moments.mean)) {
      by_tile[tile] +=
          weight * own.transpose() * MotionOf(map.world_from_tile[tile], patch.moments.mean);
    }
  }
  const Eigen::LDLT<Matrix7d> solver(all);
  for (Matrix7d& block : by_tile) block = solver.solve(block).eval();
  return by_tile;
}

}  // namespace planegraph
