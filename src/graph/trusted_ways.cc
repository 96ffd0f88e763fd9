#include "graph/trusted_ways.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <stdexcept>

#include "planegraph/base/disjoint_sets.h"

namespace planegraph {

TrustedWays::TrustedWays(int poses, const std::vector<RelativePose>& trusted) : neighbours_(poses) {
  std::vector<const RelativePose*> order;
  for (const RelativePose& measured : trusted) {
    if (std::min(measured.target, measured.source) < 0 ||
        std::max(measured.target, measured.source) >= poses) {
      throw std::invalid_argument("a trusted relative pose of a pose that is not there");
    }
    order.push_back(&measured);
  }
  // A radian counts as a metre: the lever of what a scan sees.
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return a->covariance.trace() < b->covariance.trace();
  });
  DisjointSets trees(poses);
  for (const RelativePose* measured : order) {
    const auto target = static_cast<std::size_t>(measured->target);
    const auto source = static_cast<std::size_t>(measured->source);
    if (trees.Find(target) == trees.Find(source)) continue;
    trees.Join(target, source);
    neighbours_[target].push_back(*measured);
    neighbours_[source].push_back(Inverse(*measured));
  }
}

std::vector<std::optional<Way>> TrustedWays::From(int root, int most_steps) const {
  std::vector<std::optional<Way>> ways(neighbours_.size());
  ways[root] = Way{{root, root, {}, Matrix6d::Zero()}, 0};
  std::queue<int> next({root});
  for (; !next.empty(); next.pop()) {
    const Way way = *ways[next.front()];
    if (way.steps >= most_steps) continue;
    for (const RelativePose& step : neighbours_[next.front()]) {
      if (ways[step.source]) continue;
      ways[step.source] = Way{Compose(way.pose, step), way.steps + 1};
      next.push(step.source);
    }
  }
  return ways;
}

std::vector<std::optional<Way>> TrustedWays::From(int root) const {
  return From(root, std::numeric_limits<int>::max());
}

}  // namespace planegraph
