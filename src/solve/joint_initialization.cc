#include "planegraph/solve/joint_initialization.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <queue>
#include <set>

#include "planegraph/base/disjoint_sets.h"
#include "solve/joint_linear.h"
#include "solve/pair_consensus.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

// A relative pose is taken where fewer than one in a hundred searches among mismatched landmarks
// would find its like.
constexpr double kMostLog10Chance = -2.0;
// The tree hands on the errors of single pairs; each joint solve takes most of them away.
constexpr std::array<double, 4> kWidenings = {10.0, 4.0, 2.0, 1.0};

struct Candidate {
  NodePlane plane;
  int observation;  // index in the landmark
};

struct TreeEdge {
  int target, source;
  Sim3 target_from_source;
};

double TiltSigma(const PlaneObservation& seen) {
  return std::sqrt(0.5 * (std::pow(seen.tilt_weight_1, -2) + std::pow(seen.tilt_weight_2, -2)));
}

class Initializer {
 public:
  Initializer(Graph* graph, const JointInitializationOptions& options)
      : graph_(*graph), options_(options), pose_count_(static_cast<int>(graph->poses.size())) {
    MakeNodes();
    MakeCandidates();
  }

  JointInitialization Run() {
    PlaceByTree();
    do {
      Settle();
    } while (JoinSurestParts());
    if (JoinByRelativePoses()) Settle();
    ChooseAgreeing(1.0);
    WriteBack();
    return Verdicts();
  }

 private:
  int NodeOf(const PlaneObservation& seen) const {
    return seen.map >= 0 ? pose_count_ + seen.map : seen.pose;
  }
  bool IsMap(int node) const { return node >= pose_count_; }

  void MakeNodes() {
    for (const PoseNode& pose : graph_.poses) {
      nodes_.push_back({Sim3(pose.world_from_node), pose.fixed, false});
    }
    for (const MapNode& map : graph_.maps) {
      nodes_.push_back({map.world_from_map, map.fixed, !map.fixed});
    }
  }

  // Observations that say nothing of tilt or offset take no part.
  void MakeCandidates() {
    for (const PlaneLandmark& landmark : graph_.planes) {
      std::vector<Candidate>& candidates = candidates_.emplace_back();
      for (std::size_t o = 0; o < landmark.observations.size(); ++o) {
        const PlaneObservation& seen = landmark.observations[o];
        if (!(seen.tilt_weight_1 > 0.0 && seen.tilt_weight_2 > 0.0 && seen.offset_weight > 0.0)) {
          continue;
        }
        candidates.push_back({{NodeOf(seen), seen.axes.col(0), seen.centroid, TiltSigma(seen),
                               1.0 / seen.offset_weight},
                              static_cast<int>(o)});
      }
    }
  }

  // --- the tree ---

  using SharedByPair = std::map<std::pair<int, int>, std::vector<SharedLandmark>>;

  // By (target, source): a map is the source, for its scale is what is sought.
  SharedByPair FindShared() const {
    SharedByPair shared;
    for (const auto& candidates : candidates_) {
      for (const Candidate& a : candidates) {
        for (const Candidate& b : candidates) {
          if (a.plane.node >= b.plane.node || IsMap(a.plane.node)) continue;
          shared[{a.plane.node, b.plane.node}].push_back(
              {a.plane.normal, a.plane.centroid, b.plane.normal, b.plane.centroid,
               std::hypot(a.plane.tilt_sigma, b.plane.tilt_sigma),
               std::hypot(a.plane.offset_sigma, b.plane.offset_sigma)});
        }
      }
    }
    return shared;
  }

  PairConsensusOptions PairOptions(int source) const {
    PairConsensusOptions options;
    options.gate_sigmas = options_.gate_sigmas;
    options.rotation_samples = options_.rotation_samples;
    options.translation_samples = options_.translation_samples;
    options.scale_known = !IsMap(source);
    options.seed = options_.seed;
    return options;
  }

  // The surest pairs first.
  std::vector<TreeEdge> RankedEdges() const {
    std::vector<std::pair<double, TreeEdge>> ranked;
    for (const auto& [pair, shared] : FindShared()) {
      const auto consensus = FindPairConsensus(shared, PairOptions(pair.second));
      if (!consensus || consensus->log10_chance > kMostLog10Chance) continue;
      ranked.push_back(
          {consensus->log10_chance, {pair.first, pair.second, consensus->target_from_source}});
    }
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<TreeEdge> edges;
    for (const auto& [chance, edge] : ranked) edges.push_back(edge);
    return edges;
  }

  // A component without a fixed node keeps its first one.
  void FixGauge(DisjointSets* components) {
    std::vector<bool> held(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (nodes_[i].fixed) held[components->Find(i)] = true;
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (held[components->Find(i)]) continue;
      held[components->Find(i)] = true;
      nodes_[i].fixed = true;
    }
  }

  void PlaceByTree() {
    DisjointSets components(nodes_.size());
    std::vector<std::vector<std::pair<int, Sim3>>> neighbours(nodes_.size());
    for (const TreeEdge& edge : RankedEdges()) {
      if (components.Find(edge.target) == components.Find(edge.source)) continue;
      components.Join(edge.target, edge.source);
      neighbours[edge.target].push_back({edge.source, edge.target_from_source});
      neighbours[edge.source].push_back({edge.target, edge.target_from_source.Inverse()});
    }
    FixGauge(&components);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      component_.push_back(static_cast<int>(components.Find(i)));
    }
    HandOn(neighbours);
  }

  void HandOn(const std::vector<std::vector<std::pair<int, Sim3>>>& neighbours) {
    std::vector<bool> placed(nodes_.size());
    std::queue<int> open;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      placed[i] = nodes_[i].fixed;
      if (nodes_[i].fixed) open.push(static_cast<int>(i));
    }
    for (; !open.empty(); open.pop()) {
      for (const auto& [next, here_from_next] : neighbours[open.front()]) {
        if (placed[next]) continue;
        placed[next] = true;
        nodes_[next].world_from_node = nodes_[open.front()].world_from_node * here_from_next;
        open.push(next);
      }
    }
  }

  void Settle() {
    for (double widening : kWidenings) {
      ChooseAgreeing(widening);
      SolveRotationsJointly(agreeing_, &nodes_);
      SolvePositionsJointly(agreeing_, &nodes_);
    }
  }

  // --- parts that no single pair joins ---

  // A part's own view of a landmark: the mean of its planes that agree. Their errors hang together
  // by the poses, so that the mean counts as no better than one of them.
  std::optional<NodePlane> PartPlane(const std::vector<Candidate>& candidates, int part) const {
    std::vector<Candidate> own;
    for (const Candidate& candidate : candidates) {
      if (component_[candidate.plane.node] == part) own.push_back(candidate);
    }
    const std::vector<int> set = LargestSet(own, options_.gate_sigmas);
    if (set.empty()) return {};
    NodePlane mean{part, Vector3d::Zero(), Vector3d::Zero(), 0.0, 0.0};
    const double share = 1.0 / static_cast<double>(set.size());
    for (int i : set) {
      const NodePlane& plane = own[i].plane;
      const Sim3& pose = nodes_[plane.node].world_from_node;
      mean.normal += pose.rotation * plane.normal;
      mean.centroid += share * (pose * plane.centroid);
      mean.tilt_sigma += share * plane.tilt_sigma;
      mean.offset_sigma += share * plane.offset_sigma;
    }
    mean.normal.normalize();
    return mean;
  }

  std::vector<SharedLandmark> SharedByParts(int target, int source) const {
    std::vector<SharedLandmark> shared;
    for (const auto& candidates : candidates_) {
      const auto a = PartPlane(candidates, target), b = PartPlane(candidates, source);
      if (!a || !b) continue;
      shared.push_back({a->normal, a->centroid, b->normal, b->centroid,
                        std::hypot(a->tilt_sigma, b->tilt_sigma),
                        std::hypot(a->offset_sigma, b->offset_sigma)});
    }
    return shared;
  }

  // A part's number is that of its first node; poses come before maps.
  bool IsPartOfMaps(int part) const { return IsMap(part); }

  bool MayMove(int part) const {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (component_[i] == part && IsFixedByUser(static_cast<int>(i))) return false;
    }
    return true;
  }

  bool IsFixedByUser(int node) const {
    return IsMap(node) ? graph_.maps[node - pose_count_].fixed : graph_.poses[node].fixed;
  }

  // Joins the two parts whose landmarks agree most surely: many nodes together find the few wrong
  // observations that two alone do not. False where no two do.
  bool JoinSurestParts() {
    const std::set<int> parts(component_.begin(), component_.end());
    std::optional<TreeEdge> surest;
    double least_chance = kMostLog10Chance;
    for (int target : parts) {
      for (int source : parts) {
        if (target == source || IsPartOfMaps(target) || !MayMove(source)) continue;
        if (source < target && MayMove(target)) continue;
        const auto found = FindPairConsensus(SharedByParts(target, source), PairOptions(source));
        if (!found || found->log10_chance > least_chance) continue;
        least_chance = found->log10_chance;
        surest = TreeEdge{target, source, found->target_from_source};
      }
    }
    if (surest) JoinParts(*surest);
    return surest.has_value();
  }

  void JoinParts(const TreeEdge& edge) {
    const int joined = std::min(edge.target, edge.source);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (component_[i] == edge.source) {
        nodes_[i].world_from_node = edge.target_from_source * nodes_[i].world_from_node;
        nodes_[i].fixed = false;
      }
      if (component_[i] == edge.source || component_[i] == edge.target) component_[i] = joined;
    }
  }

  // What shares too few planes hangs on what else is known: odometry, as a rule.
  bool JoinByRelativePoses() {
    bool joined = false;
    for (const PoseFactor& factor : graph_.pose_factors) {
      if (factor.type != "relative_pose" || factor.robust) continue;
      TreeEdge edge{factor.poses[0], factor.poses[1], Sim3(factor.measurement)};
      if (component_[edge.target] == component_[edge.source]) continue;
      if (!MayMove(component_[edge.source])) {
        edge = {edge.source, edge.target, edge.target_from_source.Inverse()};
      }
      if (!MayMove(component_[edge.source])) continue;
      JoinParts(BetweenParts(edge));
      joined = true;
    }
    return joined;
  }

  // The motion of the source's whole part that brings the two nodes into their relation.
  TreeEdge BetweenParts(const TreeEdge& edge) const {
    return {component_[edge.target], component_[edge.source],
            nodes_[edge.target].world_from_node * edge.target_from_source *
                nodes_[edge.source].world_from_node.Inverse()};
  }

  // --- the landmarks' observations that agree ---

  bool Agree(const NodePlane& a, const NodePlane& b, double gate) const {
    const Sim3 &pose_a = nodes_[a.node].world_from_node, &pose_b = nodes_[b.node].world_from_node;
    const Vector3d normal = pose_a.rotation * a.normal;
    const double tilt_sigma = std::hypot(a.tilt_sigma, b.tilt_sigma);
    if ((pose_b.rotation * b.normal - normal).norm() > gate * tilt_sigma) return false;
    const Vector3d apart = pose_b * b.centroid - pose_a * a.centroid;
    const double height = normal.dot(apart);
    const double lever = (apart - height * normal).norm();
    const double variance = std::pow(a.offset_sigma, 2) + std::pow(b.offset_sigma, 2) +
                            std::pow(a.tilt_sigma * lever, 2);
    return std::abs(height) <= gate * std::sqrt(variance);
  }

  // The largest set of a landmark's planes, of one component, that agree with one of them.
  std::vector<int> LargestSet(const std::vector<Candidate>& candidates, double gate) const {
    std::vector<int> largest;
    for (const Candidate& seed : candidates) {
      std::vector<int> set;
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        const NodePlane& plane = candidates[i].plane;
        if (component_[plane.node] != component_[seed.plane.node]) continue;
        if (Agree(seed.plane, plane, gate)) set.push_back(static_cast<int>(i));
      }
      if (set.size() > largest.size()) largest = std::move(set);
    }
    return largest;
  }

  void ChooseAgreeing(double widening) {
    chosen_.clear();
    agreeing_.clear();
    for (const auto& candidates : candidates_) {
      chosen_.push_back(LargestSet(candidates, widening * options_.gate_sigmas));
      std::vector<NodePlane>& planes = agreeing_.emplace_back();
      for (int i : chosen_.back()) planes.push_back(candidates[i].plane);
    }
  }

  // --- results ---

  void WriteBack() {
    for (int i = 0; i < pose_count_; ++i) {
      const Sim3& pose = nodes_[i].world_from_node;
      graph_.poses[i].world_from_node = {pose.rotation, pose.translation};
    }
    for (std::size_t m = 0; m < graph_.maps.size(); ++m) {
      graph_.maps[m].world_from_map = nodes_[pose_count_ + m].world_from_node;
    }
    for (std::size_t k = 0; k < graph_.planes.size(); ++k) PlaceLandmark(k);
  }

  void PlaceLandmark(std::size_t k) {
    PlaneLandmark& landmark = graph_.planes[k];
    std::vector<PlaneObservation> agreeing;
    for (int i : chosen_[k]) {
      agreeing.push_back(landmark.observations[candidates_[k][i].observation]);
    }
    if (agreeing.empty()) return;
    PlaneLandmark placed = MakePlaneLandmark(graph_, std::move(agreeing));
    FitLandmark(graph_, &placed);
    landmark.anchor = placed.anchor;
    landmark.normal = placed.normal;
    landmark.offset = placed.offset;
  }

  JointInitialization Verdicts() const {
    JointInitialization result;
    for (std::size_t k = 0; k < graph_.planes.size(); ++k) {
      auto& agreeing = result.agreeing.emplace_back(graph_.planes[k].observations.size(), false);
      if (chosen_[k].size() < 2) continue;
      for (int i : chosen_[k]) agreeing[candidates_[k][i].observation] = true;
    }
    result.pose_component.assign(component_.begin(), component_.begin() + pose_count_);
    result.map_component.assign(component_.begin() + pose_count_, component_.end());
    result.one_component = IsOneComponent();
    return result;
  }

  bool IsOneComponent() const {
    int first = -1;
    for (const auto& candidates : candidates_) {
      for (const Candidate& candidate : candidates) {
        if (first < 0) first = component_[candidate.plane.node];
        if (component_[candidate.plane.node] != first) return false;
      }
    }
    return true;
  }

  Graph& graph_;
  const JointInitializationOptions& options_;
  int pose_count_;
  std::vector<NodeState> nodes_;                    // poses, then maps
  std::vector<int> component_;                      // by node
  std::vector<std::vector<Candidate>> candidates_;  // by landmark
  std::vector<std::vector<int>> chosen_;            // by landmark: of its candidates
  std::vector<std::vector<NodePlane>> agreeing_;    // the same as planes
};

}  // namespace

JointInitialization InitializeJointly(Graph* graph, const JointInitializationOptions& options) {
  CheckGraph(*graph);
  if (graph->poses.empty() && graph->maps.empty()) return {{}, {}, {}, true};
  return Initializer(graph, options).Run();
}

}  // namespace planegraph
