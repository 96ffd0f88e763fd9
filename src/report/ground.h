#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "report/floor_plan.h"

namespace planegraph {

/// The height of the ground (floor or terrain) below a map, in cells of a few metres: a low
/// quantile of the heights in the cell, smoothed over its neighbours so that neither a cell that
/// shows no ground nor reflections from below the floor stand out.
class GroundModel {
 public:
  GroundModel(const Cloud& map, const PlanView& view);
  /// Metres, in the world's z; `page` as in PlanView.
  double Height(const Eigen::Vector2d& page) const {
    const Eigen::Array2d at = (page - low_).array() / cell_;
    const auto column = static_cast<std::ptrdiff_t>(at.x()),
               row = static_cast<std::ptrdiff_t>(at.y());
    return heights_[static_cast<std::size_t>(Clamp(row, rows_) * columns_ +
                                             Clamp(column, columns_))];
  }

 private:
  static std::ptrdiff_t Clamp(std::ptrdiff_t i, std::ptrdiff_t count) {
    return i < 0 ? 0 : i >= count ? count - 1 : i;
  }
  std::vector<std::vector<float>> SortIntoCells(const Cloud& map, const PlanView& view) const;
  double Smoothed(const std::vector<double>& heights, std::ptrdiff_t row,
                  std::ptrdiff_t column) const;

  Eigen::Vector2d low_;
  double cell_ = 2.0;
  std::ptrdiff_t columns_ = 1, rows_ = 1;
  std::vector<double> heights_;
};

}  // namespace planegraph
