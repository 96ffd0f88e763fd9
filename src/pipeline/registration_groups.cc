#include "pipeline/registration_groups.h"

#include <algorithm>

#include "planegraph/pipeline/loop_consistency.h"

namespace planegraph {

RegistrationGroups::RegistrationGroups(const JointProblem& problem) : problem_(problem) {
  of_pair_.assign(problem.pairs->size(), -1);
  of_map_pair_.assign(problem.map_pairs->size(), -1);
  GroupPairs();
  for (std::size_t k = 0; k < problem.map_pairs->size(); ++k) {
    const MapPairRecord& pair = (*problem.map_pairs)[k];
    if (!pair.used) continue;
    of_map_pair_[k] = count_++;
    in_map_[{static_cast<int>(pair.map), static_cast<int>(pair.scan)}] = of_map_pair_[k];
  }
}

bool RegistrationGroups::Local(std::size_t a, std::size_t b) const {
  const std::size_t apart = a < b ? b - a : a - b;
  return apart <= kLocalSteps && (*problem_.scans)[a].robot == (*problem_.scans)[b].robot;
}

void RegistrationGroups::GroupPairs() {
  const std::vector<ScanRecord>& scans = *problem_.scans;
  const int poses = static_cast<int>(scans.size());
  Loops loops = UsedLoops(scans, *problem_.pairs);
  for (std::size_t k = loops.pairs.size(); k-- > 0;) {
    const PairRecord& pair = (*problem_.pairs)[loops.pairs[k]];
    if (!Local(pair.target, pair.source)) continue;
    loops.pairs.erase(loops.pairs.begin() + static_cast<std::ptrdiff_t>(k));
    loops.closures.erase(loops.closures.begin() + static_cast<std::ptrdiff_t>(k));
  }
  const auto trusted = TrustedSteps(scans, *problem_.pairs, *problem_.odometry);
  ConsistencyOptions options;
  options.variance_factor = MeasureVarianceFactor(poses, trusted, loops.closures);
  const auto groups = GroupClosures(poses, trusted, loops.closures, kLocalSteps, options);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    of_pair_[loops.pairs[k]] = groups[k];
    count_ = std::max(count_, groups[k] + 1);
    const PairRecord& pair = (*problem_.pairs)[loops.pairs[k]];
    for (std::size_t a = 0; a < scans.size(); ++a) {
      for (std::size_t b = 0; Local(a, pair.target) && b < scans.size(); ++b) {
        if (Local(b, pair.source)) between_.try_emplace(std::minmax(a, b), groups[k]);
      }
    }
  }
}

// Of the k-th observation, a scan's, where the groups of those before it are known.
int RegistrationGroups::GroupOf(const PlaneLandmark& plane, std::size_t k,
                                const std::vector<int>& groups) const {
  const auto scan = static_cast<std::size_t>(plane.observations[k].pose);
  for (std::size_t j = k; j-- > 0;) {
    const PlaneObservation& earlier = plane.observations[j];
    if (earlier.map < 0 && Local(static_cast<std::size_t>(earlier.pose), scan)) return groups[j];
  }
  for (std::size_t j = 0; j < k; ++j) {
    const PlaneObservation& earlier = plane.observations[j];
    if (earlier.map >= 0) continue;
    const auto found =
        between_.find(std::minmax(static_cast<std::size_t>(earlier.pose), std::size_t{scan}));
    if (found != between_.end()) return found->second;
  }
  return -1;
}

int RegistrationGroups::GroupInMap(const PlaneLandmark& plane, int map) const {
  for (const PlaneObservation& seen : plane.observations) {
    if (seen.map >= 0) continue;
    const auto found = in_map_.find({map, seen.pose});
    if (found != in_map_.end()) return found->second;
  }
  return -1;
}

void RegistrationGroups::Apply(Graph* graph) const {
  for (PlaneLandmark& plane : graph->planes) {
    std::vector<int> groups;
    for (std::size_t k = 0; k < plane.observations.size(); ++k) {
      const int map = plane.observations[k].map;
      groups.push_back(map >= 0 ? GroupInMap(plane, map) : GroupOf(plane, k, groups));
    }
    for (std::size_t k = 0; k < groups.size(); ++k) plane.observations[k].group = groups[k];
  }
}

}  // namespace planegraph
