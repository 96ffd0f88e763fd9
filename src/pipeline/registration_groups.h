#pragma once

#include <map>
#include <utility>
#include <vector>

#include "planegraph/pipeline/joint_solve.h"

namespace planegraph {

/// Which registrations are right or wrong together, and which observations each of them brought.
///
/// Scans of one robot at most kLocalSteps apart are one stretch: what they share is held by many
/// registrations and by the odometry, and its observations are judged each by itself. What joins
/// two stretches, or the robots, is a loop: loop registrations of neighbouring ends that agree with
/// each other are one group (GroupClosures), as a stretch laid onto the wrong bay is so by all of
/// its scans. A scan's registration to a drone map is a group of its own.
///
/// A landmark's first scan and its stretch are its home. The observation of a scan of another
/// stretch belongs to the group that joins this stretch to an earlier one of the landmark; an
/// observation of a map to the group of the landmark's first scan that is registered to the map.
class RegistrationGroups {
 public:
  static constexpr int kLocalSteps = 3;

  explicit RegistrationGroups(const JointProblem& problem);

  /// Of pair k (place in JointProblem::pairs) or map pair; -1: none.
  int OfPair(std::size_t k) const { return of_pair_[k]; }
  int OfMapPair(std::size_t k) const { return of_map_pair_[k]; }
  int count() const { return count_; }
  /// Sets PlaneObservation::group.
  void Apply(Graph* graph) const;

 private:
  bool Local(std::size_t a, std::size_t b) const;
  void GroupPairs();
  int GroupOf(const PlaneLandmark& plane, std::size_t k, const std::vector<int>& groups) const;
  int GroupInMap(const PlaneLandmark& plane, int map) const;

  const JointProblem& problem_;
  int count_ = 0;
  std::vector<int> of_pair_, of_map_pair_;
  std::map<std::pair<std::size_t, std::size_t>, int> between_;  // of scans near a loop's ends
  std::map<std::pair<int, int>, int> in_map_;                   // of map and scan
};

}  // namespace planegraph
