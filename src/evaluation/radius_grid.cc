#include "evaluation/radius_grid.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr int kBits = 21;
constexpr std::int64_t kMaxCells = std::int64_t{1} << kBits;
// Cells get smaller until they hold about this many points, since each costs about as much.
constexpr double kPointsPerCell = 8.0;
constexpr int kMaxReach = 8;

std::uint64_t Key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>((z << (2 * kBits)) + (y << kBits) + x);
}

// One key per point; the margin keeps the keys of neighbouring cells from wrapping.
std::vector<std::uint64_t> CellKeys(const std::vector<Eigen::Vector3f>& points, double edge) {
  Eigen::Vector3d low = points.front().cast<double>(), high = low;
  for (const auto& p : points) {
    low = low.cwiseMin(p.cast<double>());
    high = high.cwiseMax(p.cast<double>());
  }
  if (((high - low) / edge).maxCoeff() > static_cast<double>(kMaxCells - 4 * kMaxReach)) {
    throw UsageError("the radius is too small for the extent of the cloud");
  }
  std::vector<std::uint64_t> keys(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d cell = (points[i].cast<double>() - low) / edge;
    keys[i] = Key(static_cast<std::int64_t>(cell.x()) + kMaxReach,
                  static_cast<std::int64_t>(cell.y()) + kMaxReach,
                  static_cast<std::int64_t>(cell.z()) + kMaxReach);
  }
  return keys;
}

double MeanOccupancy(std::vector<std::uint64_t> keys) {
  const double count = static_cast<double>(keys.size());
  std::sort(keys.begin(), keys.end());
  return count / static_cast<double>(std::unique(keys.begin(), keys.end()) - keys.begin());
}

// Nearest and farthest squared distance of a point to a box.
std::pair<float, float> SquaredDistances(const Eigen::Vector3f& p, const RadiusGrid::Cell& cell) {
  const Eigen::Array3f below = cell.low.array() - p.array(), above = p.array() - cell.high.array();
  const Eigen::Array3f near = below.max(above).max(0.0f), far = (-below).max(-above);
  return {near.square().sum(), far.square().sum()};
}

// The closed ball, decided in double: points of a lattice lie exactly on its surface.
bool IsInside(const Eigen::Vector3f& p, const Eigen::Vector3f& centre, double radius) {
  return (p.cast<double>() - centre.cast<double>()).squaredNorm() <= radius * radius;
}

}  // namespace

void RawMoments::AddShifted(const RawMoments& other, const Eigen::Vector3d& shift) {
  const double n = other.count, *s = other.sum, *q = other.square;
  const double x = shift.x(), y = shift.y(), z = shift.z();
  count += n;
  square[0] += q[0] + x * (2.0 * s[0] + n * x);
  square[1] += q[1] + x * s[1] + y * (s[0] + n * x);
  square[2] += q[2] + x * s[2] + z * (s[0] + n * x);
  square[3] += q[3] + y * (2.0 * s[1] + n * y);
  square[4] += q[4] + y * s[2] + z * (s[1] + n * y);
  square[5] += q[5] + z * (2.0 * s[2] + n * z);
  sum[0] += s[0] + n * x, sum[1] += s[1] + n * y, sum[2] += s[2] + n * z;
}

Eigen::Vector3d RawMoments::Mean() const { return Eigen::Vector3d(sum[0], sum[1], sum[2]) / count; }

Eigen::Matrix3d RawMoments::Covariance() const {
  Eigen::Matrix3d second;
  second << square[0], square[1], square[2], square[1], square[3], square[4], square[2], square[4],
      square[5];
  return second / count - Mean() * Mean().transpose();
}

RadiusGrid::RadiusGrid(const std::vector<Eigen::Vector3f>& points, double radius)
    : radius_(radius) {
  if (!(radius > 0.0) || !std::isfinite(radius)) throw UsageError("the radius must be above 0");
  if (points.empty()) throw NoResultError("the cloud has no points");
  // Scans are surfaces: halving the edge quarters the points of a cell.
  const double occupancy = MeanOccupancy(CellKeys(points, radius));
  reach_ = std::clamp(static_cast<int>(std::sqrt(occupancy / kPointsPerCell)), 1, kMaxReach);
  Sort(points, radius / reach_);
  MakeCells();
}

void RadiusGrid::Sort(const std::vector<Eigen::Vector3f>& points, double edge) {
  const std::vector<std::uint64_t> keys = CellKeys(points, edge);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> sorted(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    sorted[i] = {keys[i], static_cast<std::uint32_t>(i)};
  }
  std::sort(sorted.begin(), sorted.end());
  for (auto* axis : {&x_, &y_, &z_}) axis->resize(points.size());
  order_.resize(points.size());
  keys_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    keys_[i] = sorted[i].first;
    order_[i] = sorted[i].second;
    x_[i] = points[order_[i]].x(), y_[i] = points[order_[i]].y(), z_[i] = points[order_[i]].z();
  }
}

void RadiusGrid::MakeCells() {
  for (std::uint32_t i = 0; i < keys_.size(); ++i) {
    const Eigen::Vector3f p(x_[i], y_[i], z_[i]);
    if (i == 0 || keys_[i] != keys_[i - 1]) cells_.push_back({keys_[i], i, p, p, {}});
    cells_.back().low = cells_.back().low.cwiseMin(p);
    cells_.back().high = cells_.back().high.cwiseMax(p);
  }
  const auto end = static_cast<std::uint32_t>(keys_.size());
  cells_.push_back({~std::uint64_t{0}, end, Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(), {}});
  for (std::size_t c = 0; c + 1 < cells_.size(); ++c) {
    const Eigen::Vector3d low = cells_[c].low.cast<double>();
    for (std::uint32_t i = cells_[c].begin; i < cells_[c + 1].begin; ++i) {
      cells_[c].moments.Add(x_[i] - low.x(), y_[i] - low.y(), z_[i] - low.z());
    }
  }
  keys_ = {};
}

RadiusSweep::RadiusSweep(const RadiusGrid& grid, std::size_t first_cell) : grid_(grid) {
  // Float distances are exact to about 3e-7 of themselves.
  const double square = grid.radius() * grid.radius();
  surely_in_ = static_cast<float>(square * (1.0 - 1e-6));
  surely_out_ = static_cast<float>(square * (1.0 + 1e-6));
  const int reach = grid.reach();
  const auto& cells = grid.cells();
  for (std::int64_t z = -reach; z <= reach; ++z) {
    for (std::int64_t y = -reach; y <= reach; ++y) {
      const std::uint64_t start = cells[first_cell].key + Key(-reach, y, z);
      const auto found = std::lower_bound(
          cells.begin(), cells.end() - 1, start,
          [](const RadiusGrid::Cell& cell, std::uint64_t key) { return cell.key < key; });
      cursors_.push_back(static_cast<std::size_t>(found - cells.begin()));
    }
  }
}

void RadiusSweep::MoveTo(std::size_t cell) {
  const std::int64_t reach = grid_.reach();
  const auto& cells = grid_.cells();
  near_.clear();
  std::size_t row = 0;
  for (std::int64_t z = -reach; z <= reach; ++z) {
    for (std::int64_t y = -reach; y <= reach; ++y, ++row) {
      const std::uint64_t first = cells[cell].key + Key(-reach, y, z), last = first + 2 * reach;
      // Keys ascend with the cells walked, so a cell left behind is never met again.
      while (cells[cursors_[row]].key < first) ++cursors_[row];
      for (std::size_t c = cursors_[row]; cells[c].key <= last; ++c) {
        near_.push_back(static_cast<std::uint32_t>(c));
      }
    }
  }
}

void RadiusSweep::Find(std::uint32_t i, Neighbourhood* out) const {
  out->index = grid_.order()[i];
  out->centre = Eigen::Vector3f(grid_.x()[i], grid_.y()[i], grid_.z()[i]);
  out->moments = RawMoments();
  out->whole.clear();
  out->listed = 0;
  const auto& cells = grid_.cells();
  for (const std::uint32_t c : near_) {
    const auto [near, far] = SquaredDistances(out->centre, cells[c]);
    if (near > surely_out_) continue;
    if (far > surely_in_) {
      AddCell(cells[c], cells[c + 1].begin, out);
      continue;
    }
    const auto shift = (cells[c].low.cast<double>() - out->centre.cast<double>()).eval();
    out->moments.AddShifted(cells[c].moments, shift);
    out->whole.emplace_back(cells[c].begin, cells[c + 1].begin);
  }
  AddListed(0, out);
}

void RadiusSweep::AddCell(const RadiusGrid::Cell& cell, std::uint32_t end,
                          Neighbourhood* out) const {
  std::size_t n = out->listed;
  if (out->x.size() < n + end - cell.begin) {
    for (auto* axis : {&out->x, &out->y, &out->z}) axis->resize(2 * (n + end - cell.begin));
  }
  const float *x = grid_.x().data(), *y = grid_.y().data(), *z = grid_.z().data();
  float *to_x = out->x.data(), *to_y = out->y.data(), *to_z = out->z.data();
  const float center_x = out->centre.x(), center_y = out->centre.y(), center_z = out->centre.z();
  // Every candidate is written, and only the neighbours are kept: the outcome is hard to predict.
  for (std::uint32_t k = cell.begin; k < end; ++k) {
    const float dx = x[k] - center_x, dy = y[k] - center_y, dz = z[k] - center_z;
    const float square = dx * dx + dy * dy + dz * dz;
    to_x[n] = dx, to_y[n] = dy, to_z[n] = dz;
    bool inside = square <= surely_in_;
    if (!inside && square <= surely_out_) [[unlikely]] {
      inside = IsInside({x[k], y[k], z[k]}, out->centre, grid_.radius());
    }
    n += inside ? 1 : 0;
  }
  out->listed = n;
}

void RadiusSweep::AddListed(std::size_t first, Neighbourhood* out) const {
  RawMoments moments;
  for (std::size_t k = first; k < out->listed; ++k) moments.Add(out->x[k], out->y[k], out->z[k]);
  out->moments.AddShifted(moments, Eigen::Vector3d::Zero());
}

}  // namespace planegraph
