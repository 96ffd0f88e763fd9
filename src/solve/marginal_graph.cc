#include "planegraph/solve/marginal_graph.h"

#include <algorithm>
#include <map>
#include <set>

#include "solve/information.h"

namespace planegraph {
namespace {

using Pair = std::pair<int, int>;

Pair Ordered(const Pair& pair) { return std::minmax(pair.first, pair.second); }

std::set<int> PosesOf(const PlaneLandmark& plane) {
  std::set<int> poses;
  for (const PlaneObservation& seen : plane.observations) {
    if (seen.map < 0) poses.insert(seen.pose);
  }
  return poses;
}

// The listed pairs of which a plane's poses hold both.
std::vector<Pair> PairsOf(const std::set<int>& poses, const std::map<Pair, Matrix6d>& wanted) {
  std::vector<Pair> pairs;
  for (auto a = poses.begin(); a != poses.end(); ++a) {
    for (auto b = std::next(a); b != poses.end(); ++b) {
      if (wanted.count({*a, *b})) pairs.emplace_back(*a, *b);
    }
  }
  return pairs;
}

bool Concerns(const PlaneResidual& residual, const Pair& pair) {
  for (const BlockRef& block : residual.blocks) {
    if (block.kind == BlockKind::kMap) return false;
    if (block.kind != BlockKind::kPose) continue;
    if (block.index != pair.first && block.index != pair.second) return false;
  }
  return true;
}

// The information of a pair alone does not change when both move together: the block of one pose,
// the other held, says all. Pairs are kept with the second (larger) pose's block in world axes, the
// first held.
void AddPlane(const NodeNumbers& numbers, const PlaneLandmark& plane,
              const std::vector<PlaneResidual>& residuals, bool plane_blocks,
              std::map<Pair, Matrix6d>* wanted) {
  const std::set<int> poses = PosesOf(plane);
  const std::vector<Pair> pairs = PairsOf(poses, *wanted);
  if (pairs.empty()) return;
  const double share = std::min(1.0, (poses.size() - 1.0) / static_cast<double>(pairs.size()));
  for (const Pair& pair : pairs) {
    std::vector<const PlaneResidual*> concerned;
    for (const PlaneResidual& residual : residuals) {
      if (Concerns(residual, pair)) concerned.push_back(&residual);
    }
    PoseInformation information(numbers);
    AddPlaneInformation(concerned, plane_blocks ? share : 1.0, &information);
    (*wanted)[pair] += information.Diagonal(pair.second);
  }
}

void AddPoseFactors(const NodeNumbers& numbers, const LinearizedGraph& linear,
                    std::map<Pair, Matrix6d>* wanted) {
  for (const LinearizedPoseFactor& factor : linear.pose_factors) {
    if (factor.blocks.size() < 2 || factor.tag.pose_factor < 0) continue;
    const Pair pair = Ordered({factor.blocks[0].index, factor.blocks[1].index});
    const auto found = wanted->find(pair);
    if (found == wanted->end()) continue;
    PoseInformation information(numbers);
    AddPoseFactorInformation(factor, &information);
    found->second += information.Diagonal(pair.second);
  }
}

// Moves the information from the source's perturbation in the world, the target held, to the
// target's axes.
Matrix6d InTargetAxes(const Rigid3& world_from_target, const Matrix6d& information) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = world_from_target.rotation.toRotationMatrix();
  turn.bottomRightCorner<3, 3>() = turn.topLeftCorner<3, 3>();
  return turn.transpose() * information * turn;
}

// From "the second moves, the first held" to the reverse: a small motion (x, r) of the first about
// its own centre is, seen from it, the opposite motion of the second with the lever arm d =
// t_second - t_first: x_2 = -x + d x r, r_2 = -r.
Matrix6d HoldSecond(const Graph& graph, const Pair& pair, const Matrix6d& information) {
  const Eigen::Vector3d d = graph.poses[pair.second].world_from_node.translation -
                            graph.poses[pair.first].world_from_node.translation;
  Matrix6d change = -Matrix6d::Identity();
  change.topRightCorner<3, 3>() << 0, -d.z(), d.y(), d.z(), 0, -d.x(), -d.y(), d.x(), 0;
  return change.transpose() * information * change;
}

MarginalEdge MakeEdge(const Graph& graph, const Pair& pair, const Matrix6d& second_moves) {
  const Rigid3& world_from_target = graph.poses[pair.first].world_from_node;
  MarginalEdge edge{pair.first, pair.second,
                    world_from_target.Inverse() * graph.poses[pair.second].world_from_node,
                    second_moves};
  if (pair.first > pair.second) edge.information = HoldSecond(graph, Ordered(pair), second_moves);
  edge.information = InTargetAxes(world_from_target, edge.information);
  edge.information = (0.5 * (edge.information + edge.information.transpose())).eval();
  return edge;
}

Matrix6d G2oAxes(const Rigid3& target_from_source) {
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = target_from_source.rotation.toRotationMatrix();
  axes.bottomRightCorner<3, 3>() = 2.0 * axes.topLeftCorner<3, 3>();
  return axes;
}

}  // namespace

std::vector<MarginalEdge> MarginalEdges(const Graph& graph, const std::vector<Pair>& pairs,
                                        const SolveOptions& options) {
  CheckGraph(graph);
  const NodeNumbers numbers(graph);
  const LinearizedGraph linear = LinearizeGraph(graph, options);
  const FactorType& type = BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);
  const bool plane_blocks = type.plane_blocks || !type.linearized_as.empty();
  std::map<Pair, Matrix6d> wanted;
  for (const Pair& pair : pairs) wanted[Ordered(pair)] = Matrix6d::Zero();
  for (std::size_t k = 0; k < graph.planes.size(); ++k) {
    AddPlane(numbers, graph.planes[k], linear.planes[k], plane_blocks, &wanted);
  }
  AddPoseFactors(numbers, linear, &wanted);
  std::vector<MarginalEdge> edges;
  for (const Pair& pair : pairs) edges.push_back(MakeEdge(graph, pair, wanted[Ordered(pair)]));
  return edges;
}

Matrix6d G2oInformation(const Rigid3& target_from_source, const Matrix6d& information) {
  const Matrix6d axes = G2oAxes(target_from_source);
  return axes.transpose() * information * axes;
}

Matrix6d InformationFromG2o(const Rigid3& target_from_source, const Matrix6d& omega) {
  const Matrix6d inverse = G2oAxes(target_from_source).inverse();
  return inverse.transpose() * omega * inverse;
}

}  // namespace planegraph
