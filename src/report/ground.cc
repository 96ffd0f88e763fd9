#include "report/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planegraph {
namespace {

constexpr std::size_t kMostGroundPoints = 200000;
constexpr std::size_t kLeastPerCell = 5;
constexpr double kUnknownHeight = std::numeric_limits<double>::quiet_NaN();

double Quantile(std::vector<float>* values, double share) {
  if (values->size() < kLeastPerCell) return kUnknownHeight;
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + k, values->end());
  return (*values)[static_cast<std::size_t>(k)];
}

}  // namespace

GroundModel::GroundModel(const Cloud& map, const PlanView& view) : low_(view.low) {
  const Eigen::Vector2d extent = view.Extent();
  cell_ = std::max(2.0, extent.maxCoeff() / 200.0);
  columns_ = static_cast<std::ptrdiff_t>(std::ceil(extent.x() / cell_));
  rows_ = static_cast<std::ptrdiff_t>(std::ceil(extent.y() / cell_));
  std::vector<std::vector<float>> cells = SortIntoCells(map, view);
  std::vector<double> lows;
  for (auto& cell : cells) lows.push_back(Quantile(&cell, 0.1));
  for (std::ptrdiff_t row = 0; row < rows_; ++row) {
    for (std::ptrdiff_t column = 0; column < columns_; ++column) {
      heights_.push_back(Smoothed(lows, row, column));
    }
  }
}

std::vector<std::vector<float>> GroundModel::SortIntoCells(const Cloud& map,
                                                           const PlanView& view) const {
  std::vector<std::vector<float>> cells(static_cast<std::size_t>(rows_ * columns_));
  const std::size_t stride = 1 + map.size() / kMostGroundPoints;
  for (std::size_t i = 0; i < map.size(); i += stride) {
    const Eigen::Vector3d p = map.Position(i);
    const Eigen::Array2d at = (view.OnPage(p.head<2>()) - low_).array() / cell_;
    if (!(at >= 0.0).all() || at.x() >= double(columns_) || at.y() >= double(rows_)) continue;
    const auto cell =
        static_cast<std::ptrdiff_t>(at.y()) * columns_ + static_cast<std::ptrdiff_t>(at.x());
    cells[static_cast<std::size_t>(cell)].push_back(static_cast<float>(p.z()));
  }
  return cells;
}

// The lower quartile of the cells around: walls that hide the floor count less than the floor
// beside them.
double GroundModel::Smoothed(const std::vector<double>& heights, std::ptrdiff_t row,
                             std::ptrdiff_t column) const {
  std::vector<double> known;
  for (std::ptrdiff_t reach = 2; known.empty() && reach <= std::max(rows_, columns_) + 2;
       reach *= 2) {
    for (auto r = std::max<std::ptrdiff_t>(0, row - reach); r <= std::min(rows_ - 1, row + reach);
         ++r) {
      for (auto c = std::max<std::ptrdiff_t>(0, column - reach);
           c <= std::min(columns_ - 1, column + reach); ++c) {
        const double height = heights[static_cast<std::size_t>(r * columns_ + c)];
        if (!std::isnan(height)) known.push_back(height);
      }
    }
  }
  if (known.empty()) return 0.0;
  const auto k = static_cast<std::ptrdiff_t>(known.size() / 4);
  std::nth_element(known.begin(), known.begin() + k, known.end());
  return known[static_cast<std::size_t>(k)];
}

}  // namespace planegraph
