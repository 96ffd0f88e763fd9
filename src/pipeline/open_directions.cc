#include "pipeline/open_directions.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/disjoint_sets.h"

namespace planegraph {
namespace {

constexpr double kHoldSigma = 1e-3;  // metres: how tightly odometry holds an open direction

// What the registrations say of one direction of translation (world's axes): which nodes, scans
// and then maps, they tie to each other along it.
class TiesAlong {
 public:
  TiesAlong(const JointProblem& problem, const JointSolution& solution,
            const Eigen::Vector3d& direction)
      : direction_(direction), nodes_(problem.scans->size() + problem.maps->size()) {
    for (const PairRecord& pair : *problem.pairs) {
      const auto& axes = solution.world_from_scan[pair.target].rotation;
      if (pair.used && !IsOpen(axes, pair.registration.unobserved)) {
        nodes_.Join(pair.target, pair.source);
      }
    }
    for (const MapPairRecord& pair : *problem.map_pairs) {
      const auto& axes = solution.world_from_metric[pair.map].rotation;
      if (pair.used && !IsOpen(axes, pair.refinement)) {
        nodes_.Join(pair.scan, problem.scans->size() + pair.map);
      }
    }
  }

  bool IsAlong(const Eigen::Vector3d& direction) const {
    return std::abs(direction.dot(direction_)) > kSameDirection;
  }
  bool Tie(std::size_t a, std::size_t b) { return nodes_.Find(a) == nodes_.Find(b); }

 private:
  static constexpr double kSameDirection = 0.985;  // 10 deg
  static constexpr double kOpenShare = 0.25;       // of the direction that lies in what is open

  bool IsOpen(const Eigen::Quaterniond& world_from_target,
              const std::vector<UnobservedDirection>& unobserved) const {
    double share = 0.0;
    for (const UnobservedDirection& open : unobserved) {
      const Eigen::Vector3d in_world = world_from_target * open.direction.head<3>();
      share += std::pow(in_world.dot(direction_), 2);
    }
    return share > kOpenShare;
  }

  bool IsOpen(const Eigen::Quaterniond& world_from_map, const MapRefinement& refinement) const {
    const Eigen::Vector3d in_map = world_from_map.conjugate() * direction_;
    const double variance = in_map.dot(refinement.covariance.topLeftCorner<3, 3>() * in_map);
    return !(variance < std::pow(RegistrationOptions().weak_translation, 2));
  }

  Eigen::Vector3d direction_;
  DisjointSets nodes_;
};

TiesAlong& FindTies(const JointProblem& problem, const JointSolution& solution,
                    const Eigen::Vector3d& direction, std::vector<TiesAlong>* known) {
  const auto found = std::find_if(known->begin(), known->end(),
                                  [&](const TiesAlong& t) { return t.IsAlong(direction); });
  if (found != known->end()) return *found;
  return known->emplace_back(problem, solution, direction);
}

// Along directions that the planes leave open the estimate shall follow the odometry, not what the
// noise of many normals adds up to. Where other registrations tie the two scans along them they are
// not open in the graph, though one pair alone leaves them so.
Matrix6d InformationOfOpen(const JointProblem& problem, const JointSolution& solution,
                           const PairRecord& pair, std::vector<TiesAlong>* ties) {
  Matrix6d information = Matrix6d::Zero();
  for (const auto& open : pair.registration.unobserved) {
    if (open.direction.head<3>().norm() < 0.5) continue;
    const Eigen::Vector3d in_world =
        solution.world_from_scan[pair.target].rotation * open.direction.head<3>();
    if (FindTies(problem, solution, in_world, ties).Tie(pair.target, pair.source)) continue;
    information += open.direction * open.direction.transpose() / (kHoldSigma * kHoldSigma);
  }
  return information;
}

}  // namespace

void HoldOpenDirections(const JointProblem& problem, const JointSolution& solution, Graph* graph) {
  std::vector<TiesAlong> ties;
  for (const PairRecord& pair : *problem.pairs) {
    const OdometryStep* step = FindStep(*problem.odometry, pair);
    if (!pair.used || step == nullptr) continue;
    const Matrix6d information = InformationOfOpen(problem, solution, pair, &ties);
    if (information.isZero()) continue;
    graph->pose_factors.push_back(MakeRelativePose(static_cast<int>(step->target),
                                                   static_cast<int>(step->source),
                                                   step->target_from_source, information, "hold"));
  }
}

}  // namespace planegraph
