#include "plane_subset.h"

#include <algorithm>
#include <numeric>

namespace planegraph {

PlaneSet Subset(const PlaneSet& all, const std::vector<std::size_t>& kept) {
  std::vector<int> index(all.planes.size(), -1);
  PlaneSet subset = all;
  subset.planes.clear();
  subset.patches.clear();
  for (const std::size_t k : kept) {
    index[k] = static_cast<int>(subset.planes.size());
    subset.planes.push_back(all.planes[k]);
  }
  for (Patch patch : all.patches) {
    if (patch.segment < 0 || index[static_cast<std::size_t>(patch.segment)] < 0) continue;
    patch.segment = index[static_cast<std::size_t>(patch.segment)];
    subset.patches.push_back(patch);
  }
  return subset;
}

PlaneSet LargestPlanes(const PlaneSet& planes, std::size_t most) {
  std::vector<std::size_t> order(planes.planes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return planes.planes[a].area > planes.planes[b].area;
  });
  order.resize(std::min(order.size(), most));
  return Subset(planes, order);
}

}  // namespace planegraph
