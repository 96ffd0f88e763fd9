#include "solve/open_motions.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "planegraph/base/disjoint_sets.h"
#include "planegraph/geometry/rotation.h"
#include "solve/quantity.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
// Open directions that differ by less are one: sine of 15 degrees.
constexpr double kSameDirections = 0.26;

// What is open at one node, relative to its component's reference.
struct OpenNode {
  int node;
  MotionKind kind;
  Matrix3d projector;  // onto the open directions
  int dimension;
  double sigma;
};

// Nodes with equal open directions.
struct Cluster {
  std::vector<OpenNode> members;
  Matrix3d sum = Matrix3d::Zero();

  bool Takes(const OpenNode& open) const {
    if (open.kind != members[0].kind || open.dimension != members[0].dimension) return false;
    if (open.kind == MotionKind::kScale) return false;  // every map by itself
    const Matrix3d mean = sum / static_cast<double>(members.size());
    return (mean - open.projector).norm() < std::sqrt(2.0) * kSameDirections;
  }
  void Add(const OpenNode& open) {
    members.push_back(open);
    sum += open.projector;
  }
  MatrixXd Axes() const {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(sum);
    return solver.eigenvectors().rightCols(members[0].dimension);
  }
};

class Finder {
 public:
  Finder(const Graph& graph, const PoseInformation& information, const CovarianceOptions& options)
      : graph_(graph), information_(information), options_(options), sets_(NodeCount(graph)) {
    information.ForEach([&](int row, int column, const NodeBlock&) { sets_.Join(row, column); });
    FindFollowers();
    ChooseReferences();
    system_ = std::make_unique<PoseSystem>(information, gauge_);
  }

  std::vector<OpenMotion> Run() {
    std::vector<OpenMotion> motions;
    AddComponents(&motions);
    for (const auto& [reference, nodes] : components_) {
      for (const Cluster& cluster : Clusters(reference, nodes)) {
        motions.push_back(Motion(reference, nodes, cluster));
      }
    }
    return motions;
  }

 private:
  static std::size_t NodeCount(const Graph& graph) {
    return graph.poses.size() + graph.maps.size();
  }
  bool IsMap(int node) const { return node >= static_cast<int>(graph_.poses.size()); }
  // Maps that no scan is registered to take no part. Of maps that are tied, the tiles of one, the
  // best observed stands for all: how they bend is no motion of the whole.
  bool TakesPart(int node) const {
    return !IsMap(node) || (information_.Find(node, node) != nullptr && !follows_.count(node));
  }
  void FindFollowers();
  void ChooseReferences();
  double Hold(int node) const;
  void AddComponents(std::vector<OpenMotion>* motions) const;
  void AddOpen(int node, MotionKind kind, const Matrix3d& covariance,
               std::vector<OpenNode>* open) const;
  std::vector<Cluster> Clusters(int reference, const std::vector<int>& nodes) const;
  OpenMotion Motion(int reference, const std::vector<int>& nodes, const Cluster& cluster) const;
  std::vector<std::vector<int>> Parts(const std::vector<int>& nodes, const Cluster& cluster) const;
  bool Keeps(int a, int b, const Cluster& cluster, const MatrixXd& axes) const;
  double Threshold(MotionKind kind) const {
    return kind == MotionKind::kRotation ? options_.rotation_threshold
                                         : options_.translation_threshold;
  }

  const Graph& graph_;
  const PoseInformation& information_;
  const CovarianceOptions& options_;
  DisjointSets sets_;
  std::set<int> follows_;  // tied maps for which another stands
  Gauge gauge_;
  std::map<int, std::vector<int>> components_;  // by their references
  std::unique_ptr<PoseSystem> system_;
};

// How well a node's planes hold it, with all others held: by the direction that they hold least,
// translations and rotations in units of their thresholds.
double Finder::Hold(int node) const {
  Matrix6d block = information_.Diagonal(node);
  Vector6d unit;
  unit << Vector3d::Constant(options_.translation_threshold),
      Vector3d::Constant(options_.rotation_threshold);
  block = unit.asDiagonal() * block * unit.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(block, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

void Finder::FindFollowers() {
  const int poses = static_cast<int>(graph_.poses.size());
  DisjointSets tied(NodeCount(graph_));
  std::set<int> tiles;
  for (const MapFactor& factor : graph_.map_factors) {
    if (factor.maps.size() != 2) continue;
    tied.Join(poses + factor.maps[0], poses + factor.maps[1]);
    tiles.insert({poses + factor.maps[0], poses + factor.maps[1]});
  }
  std::map<std::size_t, int> best;
  const auto scale = [&](int node) {
    const NodeBlock* block = information_.Find(node, node);
    return block != nullptr ? (*block)(6, 6) : 0.0;
  };
  for (const int tile : tiles) {
    int& leader = best.try_emplace(tied.Find(tile), tile).first->second;
    if (scale(tile) > scale(leader)) leader = tile;
  }
  for (const int tile : tiles) {
    if (best.at(tied.Find(tile)) != tile) follows_.insert(tile);
  }
}

void Finder::ChooseReferences() {
  const int count = static_cast<int>(NodeCount(graph_));
  gauge_.poses.assign(graph_.poses.size(), false);
  gauge_.maps.assign(graph_.maps.size(), false);
  std::map<std::size_t, std::vector<int>> by_set;
  for (int node = 0; node < count; ++node) {
    if (TakesPart(node)) by_set[sets_.Find(static_cast<std::size_t>(node))].push_back(node);
    if (!TakesPart(node) && !follows_.count(node)) gauge_.maps[node - graph_.poses.size()] = true;
  }
  for (auto& [first, nodes] : by_set) {
    int best = nodes.front();
    double hold = -1.0;
    for (const int node : nodes) {
      if (IsMap(node)) break;  // poses come first
      const double own = Hold(node);
      // By rounding alone no later one is better.
      if (own > hold * (1.0 + 1e-6) + 1e-9) best = node, hold = own;
    }
    gauge_.poses[best] = true;
    components_[best] = std::move(nodes);
  }
}

// Components that share no plane.
void Finder::AddComponents(std::vector<OpenMotion>* motions) const {
  if (components_.size() < 2) return;
  OpenMotion motion;
  motion.kind = MotionKind::kEverything;
  for (const auto& [reference, nodes] : components_) motion.parts.push_back(nodes);
  std::stable_sort(motion.parts.begin(), motion.parts.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  motion.degrees_of_freedom = 6 * (static_cast<int>(motion.parts.size()) - 1);
  motion.sigma_planes = motion.sigma = kUnbounded;
  motion.reference = motion.parts[0].front();
  motion.node = motion.parts[1].front();
  motions->push_back(std::move(motion));
}

void Finder::AddOpen(int node, MotionKind kind, const Matrix3d& covariance,
                     std::vector<OpenNode>* open) const {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  OpenNode found{node, kind, Matrix3d::Zero(), 0, 0.0};
  const double threshold = Threshold(kind);
  for (int k = 2; k >= 0 && solver.eigenvalues()[k] > threshold * threshold; --k) {
    const Vector3d axis = solver.eigenvectors().col(k);
    found.projector += axis * axis.transpose();
    ++found.dimension;
  }
  if (found.dimension == 0) return;
  const bool infinite = solver.eigenvalues()[2] >
                        system_->InfiniteVariance(node, kind == MotionKind::kRotation ? 3 : 0);
  found.sigma = infinite ? kUnbounded : std::sqrt(solver.eigenvalues()[2]);
  open->push_back(found);
}

std::vector<Cluster> Finder::Clusters(int reference, const std::vector<int>& nodes) const {
  std::vector<OpenNode> open;
  for (const int node : nodes) {
    if (node == reference) continue;
    const MatrixXd moved = MotionSeenFrom(graph_, reference, node).by_k;
    const MatrixXd covariance = moved * system_->Block(node, node) * moved.transpose();
    AddOpen(node, MotionKind::kTranslation, covariance.topLeftCorner<3, 3>(), &open);
    AddOpen(node, MotionKind::kRotation, covariance.bottomRightCorner<3, 3>(), &open);
    if (!IsMap(node)) continue;
    const double variance = system_->Block(node, node)(6, 6);
    if (variance <= std::pow(options_.scale_threshold, 2)) continue;
    // A scale of which nothing is known leaves no digits of others: beyond 100 it is infinite.
    open.push_back({node, MotionKind::kScale, Matrix3d::Zero(), 1,
                    variance > 1e4 ? kUnbounded : std::sqrt(variance)});
  }
  std::vector<Cluster> clusters;
  for (const OpenNode& one : open) {
    const auto place = std::find_if(clusters.begin(), clusters.end(),
                                    [&](const Cluster& cluster) { return cluster.Takes(one); });
    Cluster& cluster = place == clusters.end() ? clusters.emplace_back() : *place;
    cluster.Add(one);
  }
  return clusters;
}

// Whether two nodes with planes in common keep their places relative to each other.
bool Finder::Keeps(int a, int b, const Cluster& cluster, const MatrixXd& axes) const {
  const MotionKind kind = cluster.members[0].kind;
  const SeenMotion seen = MotionSeenFrom(graph_, a, b);
  const int first = kind == MotionKind::kRotation ? 3 : 0;
  const MatrixXd by_a = axes.transpose() * seen.by_i.middleRows<3>(first);
  const MatrixXd by_b = axes.transpose() * seen.by_k.middleRows<3>(first);
  const MatrixXd covariance = CovarianceOf(*system_, {{a, by_a}, {b, by_b}});
  const double largest =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(covariance).eigenvalues()[axes.cols() - 1];
  return largest <= Threshold(kind) * Threshold(kind);
}

std::vector<std::vector<int>> Finder::Parts(const std::vector<int>& nodes,
                                            const Cluster& cluster) const {
  std::set<int> members;
  for (const OpenNode& open : cluster.members) members.insert(open.node);
  DisjointSets parts(NodeCount(graph_));
  int rest = -1;  // what is not open against the reference stays with it
  for (const int node : nodes) {
    if (members.count(node)) continue;
    if (rest >= 0) parts.Join(rest, node);
    rest = node;
  }
  const MatrixXd axes = cluster.Axes();
  information_.ForEach([&](int row, int column, const NodeBlock&) {
    if (!members.count(row) && !members.count(column)) return;
    if (parts.Find(row) == parts.Find(column)) return;
    if (Keeps(row, column, cluster, axes)) parts.Join(row, column);
  });
  std::map<std::size_t, std::vector<int>> by_part;
  for (const int node : nodes) by_part[parts.Find(node)].push_back(node);
  std::vector<std::vector<int>> found;
  for (auto& [first, part] : by_part) found.push_back(std::move(part));
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return found;
}

// Signs and order of eigenvectors are free.
std::vector<Vector3d> Tidy(const MatrixXd& axes) {
  std::vector<Vector3d> tidy;
  for (Eigen::Index k = axes.cols() - 1; k >= 0; --k) {
    Vector3d axis = axes.col(k);
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    tidy.push_back(axis[largest] < 0.0 ? Vector3d(-axis) : axis);
  }
  return tidy;
}

OpenMotion Finder::Motion(int reference, const std::vector<int>& nodes,
                          const Cluster& cluster) const {
  OpenMotion motion;
  motion.kind = cluster.members[0].kind;
  motion.reference = reference;
  if (motion.kind == MotionKind::kScale) {
    motion.parts = {{reference}, {cluster.members[0].node}};
  } else {
    motion.axes = Tidy(cluster.Axes());
    motion.parts = Parts(nodes, cluster);
  }
  motion.degrees_of_freedom =
      cluster.members[0].dimension * (static_cast<int>(motion.parts.size()) - 1);
  for (const OpenNode& open : cluster.members) {
    if (open.sigma > motion.sigma_planes) motion.sigma_planes = open.sigma, motion.node = open.node;
  }
  return motion;
}

// A map's place is where scans are: its own origin may be anywhere.
Vector3d PlaceOf(const Graph& graph, int node) {
  const std::size_t poses = graph.poses.size();
  if (node < static_cast<int>(poses)) return graph.poses[node].world_from_node.translation;
  Vector3d mean = Vector3d::Zero();
  for (const PoseNode& pose : graph.poses) mean += pose.world_from_node.translation;
  return mean / static_cast<double>(poses);
}

// How a point that moves with a node moves, by the node's perturbation.
MatrixXd MotionAt(const Graph& graph, int node, const Vector3d& place) {
  const int poses = static_cast<int>(graph.poses.size());
  const bool is_map = node >= poses;
  const Vector3d arm = place - (is_map ? graph.maps[node - poses].world_from_map.translation
                                       : graph.poses[node].world_from_node.translation);
  MatrixXd motion = MatrixXd::Zero(6, is_map ? 7 : 6);
  motion.block<6, 6>(0, 0).setIdentity();
  motion.block<3, 3>(0, 3) = -Hat(arm);
  if (is_map) motion.block<3, 1>(0, 6) = arm;
  return motion;
}

}  // namespace

SeenMotion MotionSeenFrom(const Graph& graph, int i, int k) {
  const Vector3d place = PlaceOf(graph, k);
  return {-MotionAt(graph, i, place), MotionAt(graph, k, place)};
}

std::vector<OpenMotion> FindOpenMotions(const Graph& graph, const PoseInformation& by_planes,
                                        const CovarianceOptions& options) {
  if (graph.poses.empty()) return {};
  return Finder(graph, by_planes, options).Run();
}

}  // namespace planegraph
