#include "planegraph/cloud/units.h"

#include "planegraph/base/median.h"

namespace planegraph {

bool AreUnitsDoubtful(const Cloud& cloud) {
  constexpr double kDoubtfulMetres = 100.0;
  std::vector<double> ranges;
  ranges.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ranges.push_back((cloud.Position(i) - cloud.viewpoint).norm());
  }
  return Median(std::move(ranges)) > kDoubtfulMetres;
}

}  // namespace planegraph
