#include "planegraph/correspondence/section_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planegraph {
namespace {

constexpr double kEdge = 10.0;  // metres: sections are some ten to fifty wide

long ColumnOf(double metres) { return std::lround(std::floor(metres / kEdge)); }

}  // namespace

SectionIndex::SectionIndex(const std::vector<Surfel>& surfels) {
  for (std::uint32_t i = 0; i < surfels.size(); ++i) {
    columns_[{ColumnOf(surfels[i].mean.x()), ColumnOf(surfels[i].mean.y())}].push_back(i);
  }
}

std::vector<std::uint32_t> SectionIndex::Near(const Eigen::Vector3d& centre, double radius) const {
  std::vector<std::uint32_t> found;
  if (!centre.allFinite() || !(radius >= 0.0)) return found;
  constexpr long kFirst = std::numeric_limits<long>::min();
  const long low = ColumnOf(centre.y() - radius), high = ColumnOf(centre.y() + radius);
  const long end = ColumnOf(centre.x() + radius);
  auto at = columns_.lower_bound({ColumnOf(centre.x() - radius), kFirst});
  while (at != columns_.end() && at->first.first <= end) {
    const auto [x, y] = at->first;
    if (y < low) {
      at = columns_.lower_bound({x, low});
    } else if (y > high) {
      at = columns_.lower_bound({x + 1, kFirst});
    } else {
      found.insert(found.end(), at->second.begin(), at->second.end());
      ++at;
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace planegraph
