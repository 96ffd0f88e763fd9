#include "planegraph/solve/joint_initialization.h"

#include <algorithm>
#include <array>
#include <optional>
#include <queue>
#include <set>

#include "planegraph/base/disjoint_sets.h"
#include "planegraph/base/median.h"
#include "solve/node_views.h"

namespace planegraph {
namespace {

// A relative pose is sure where its lead over the next best one has a chance below one in a
// hundred.
constexpr double kSure = -2.0;
// At the end what is left is placed by its best guess, if that has any lead.
constexpr double kGuess = -0.1;
// The tree hands on the errors of single pairs; each joint solve takes most of them away.
constexpr std::array<double, 3> kWidenings = {2.0, 1.0, 1.0};

struct TreeEdge {
  int target, source;
  Sim3 target_from_source;
};

class Initializer {
 public:
  Initializer(Graph* graph, const JointInitializationOptions& options)
      : graph_(*graph),
        options_(options),
        pose_count_(static_cast<int>(graph->poses.size())),
        views_(*graph) {
    for (const PoseNode& pose : graph_.poses) {
      nodes_.push_back({Sim3(pose.world_from_node), pose.fixed, false});
    }
    for (const MapNode& map : graph_.maps) {
      nodes_.push_back({map.world_from_map, map.fixed, !map.fixed});
    }
  }

  JointInitialization Run() {
    PlaceByTree();
    do {
      Settle();
    } while (JoinSurestParts(kSure) || JoinSurestParts(kGuess));
    if (JoinByRelativePoses()) Settle();
    ChooseAgreeing(1.0);
    WriteBack();
    return Verdicts();
  }

 private:
  // --- the tree ---

  PairConsensusOptions PairOptions(int source) const {
    PairConsensusOptions options;
    options.gate_sigmas = options_.gate_sigmas;
    options.rotation_samples = options_.rotation_samples;
    options.translation_samples = options_.translation_samples;
    options.scale_known = !views_.IsMap(source);
    options.seed = options_.seed;
    return options;
  }

  // The surest pairs first.
  std::vector<TreeEdge> RankedEdges() {
    std::vector<std::pair<double, TreeEdge>> ranked;
    std::vector<double> widenings;
    for (const auto& [pair, shared] : views_.FindShared()) {
      const auto consensus = FindPairConsensus(shared, PairOptions(pair.second));
      if (!consensus || consensus->log10_chance > kSure) continue;
      widenings.push_back(consensus->widening);
      ranked.push_back(
          {consensus->log10_chance, {pair.first, pair.second, consensus->target_from_source}});
    }
    widening_ = Median(std::move(widenings), 1.0);
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
      const std::vector<NodeState> before = nodes_;
      const std::vector<int> had = AgreeingByNode();
      SolveRotationsJointly(agreeing_, &nodes_);
      SolvePositionsJointly(agreeing_, &nodes_);
      ChooseAgreeing(widening);
      const std::vector<int> has = AgreeingByNode();
      // A node of few planes can be pulled off by wrong ones.
      for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (has[i] < had[i]) nodes_[i] = before[i];
      }
    }
  }

  // How many of its planes agree with those of other nodes.
  std::vector<int> AgreeingByNode() const {
    std::vector<int> count(nodes_.size());
    for (const auto& planes : agreeing_) {
      if (planes.size() < 2) continue;
      for (const NodePlane& plane : planes) ++count[plane.node];
    }
    return count;
  }

  // --- parts that no single pair joins ---

  // A part's number is that of its first node; poses come before maps.
  bool IsPartOfMaps(int part) const { return views_.IsMap(part); }

  bool MayMove(int part) const {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (component_[i] == part && IsFixedByUser(static_cast<int>(i))) return false;
    }
    return true;
  }

  bool IsFixedByUser(int node) const {
    return views_.IsMap(node) ? graph_.maps[node - pose_count_].fixed : graph_.poses[node].fixed;
  }

  // Joins the two parts whose landmarks agree most surely: many nodes together find the few wrong
  // observations that two alone do not. False where no two do.
  bool JoinSurestParts(double most_log10_chance) {
    const std::set<int> parts(component_.begin(), component_.end());
    std::optional<TreeEdge> surest;
    double least_chance = most_log10_chance;
    for (int target : parts) {
      for (int source : parts) {
        if (target == source || IsPartOfMaps(target) || !MayMove(source)) continue;
        if (source < target && MayMove(target)) continue;
        const auto found = FindPairConsensus(
            views_.SharedByParts(target, source, nodes_, component_, Gate()), PairOptions(source));
        if (!found || found->log10_chance > least_chance) continue;
        least_chance = found->log10_chance;
        surest = TreeEdge{target, source, found->target_from_source};
      }
    }
    if (!surest) return false;
    JoinParts(*surest);
    least_sure_ = std::max(least_sure_, least_chance);
    return true;
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

  double Gate() const { return widening_ * options_.gate_sigmas; }

  void ChooseAgreeing(double widening) {
    chosen_.clear();
    agreeing_.clear();
    for (std::size_t k = 0; k < views_.LandmarkCount(); ++k) {
      const auto& views = views_.OfLandmark(k);
      chosen_.push_back(NodeViews::LargestSet(views, nodes_, component_, widening * Gate()));
      std::vector<NodePlane>& planes = agreeing_.emplace_back();
      for (int i : chosen_.back()) planes.push_back(views[i].plane);
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
      agreeing.push_back(landmark.observations[views_.OfLandmark(k)[i].observation]);
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
      for (int i : chosen_[k]) agreeing[views_.OfLandmark(k)[i].observation] = true;
    }
    result.pose_component.assign(component_.begin(), component_.begin() + pose_count_);
    result.map_component.assign(component_.begin() + pose_count_, component_.end());
    result.one_component = IsOneComponent();
    result.least_sure_log10_chance = least_sure_;
    return result;
  }

  bool IsOneComponent() const {
    int first = -1;
    for (std::size_t k = 0; k < views_.LandmarkCount(); ++k) {
      for (const NodeViews::View& view : views_.OfLandmark(k)) {
        if (first < 0) first = component_[view.plane.node];
        if (component_[view.plane.node] != first) return false;
      }
    }
    return true;
  }

  Graph& graph_;
  const JointInitializationOptions& options_;
  int pose_count_;
  NodeViews views_;
  double least_sure_ = kSure;                     // log10 of the chance, of all that was joined
  double widening_ = 1.0;                         // of the stated deviations, as the pairs found it
  std::vector<NodeState> nodes_;                  // poses, then maps
  std::vector<int> component_;                    // by node
  std::vector<std::vector<int>> chosen_;          // by landmark: of its views
  std::vector<std::vector<NodePlane>> agreeing_;  // the same as planes
};

}  // namespace

JointInitialization InitializeJointly(Graph* graph, const JointInitializationOptions& options) {
  CheckGraph(*graph);
  if (graph->poses.empty() && graph->maps.empty()) return {{}, {}, {}, true, kSure};
  return Initializer(graph, options).Run();
}

}  // namespace planegraph
