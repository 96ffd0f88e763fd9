#include "planegraph/solve/joint_initialization.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "planegraph/base/median.h"
#include "solve/node_views.h"

namespace planegraph {
namespace {

// A relative pose is sure where its lead over the next best one has a chance below one in a
// hundred.
constexpr double kSureToJoin = -2.0;
// At the end what is left is placed by its best guess, if that has any lead.
constexpr double kGuess = -1e-3;
// A join has the error of its two parts' planes; each joint solve takes most of it away.
constexpr std::array<double, 3> kJointWidenings = {2.0, 1.0, 1.0};

struct PartMotion {
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
      nodes_.push_back({Sim3(pose.world_from_node), true, false});
    }
    for (const MapNode& map : graph_.maps) {
      nodes_.push_back({map.world_from_map, true, !map.fixed});
    }
    component_.resize(nodes_.size());
    std::iota(component_.begin(), component_.end(), 0);
  }

  JointInitialization Run() {
    ProposeJoins();
    MeasureWidening();
    while (JoinSurestParts(kSureToJoin) || JoinSurestParts(kGuess)) Settle();
    if (JoinByRelativePoses()) Settle();
    ChooseAgreeing(1.0);
    WriteBack();
    return Verdicts();
  }

 private:
  PairConsensusOptions PairOptions(int source) const {
    PairConsensusOptions options;
    options.gate_sigmas = options_.gate_sigmas;
    options.rotation_samples = options_.rotation_samples;
    options.translation_samples = options_.translation_samples;
    options.scale_known = !views_.IsMap(source);
    options.seed = options_.seed;
    return options;
  }

  void Settle() {
    for (double widening : kJointWidenings) {
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

  // --- the parts and their joins ---

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

  struct Proposal {
    PartMotion motion;
    double log10_chance;
    double widening;
  };

  std::optional<Proposal> Propose(int target, int source) const {
    const auto found = FindPairConsensus(
        views_.SharedByParts(target, source, nodes_, component_, Gate()), PairOptions(source));
    if (!found) return {};
    return Proposal{
        {target, source, found->target_from_source}, found->log10_chance, found->widening};
  }

  // Every two parts once, for those of them that have changed; the one that moves is the source.
  void ProposeJoins() {
    const std::set<int> parts(component_.begin(), component_.end());
    for (int target : parts) {
      for (int source : parts) {
        if (target == source || IsPartOfMaps(target) || !MayMove(source)) continue;
        if (source < target && MayMove(target)) continue;
        if (proposals_.count({target, source}) > 0) continue;
        proposals_[{target, source}] = Propose(target, source);
      }
    }
  }

  // By how much the stated deviations must be widened, as sure pairs of nodes find it.
  void MeasureWidening() {
    std::vector<double> widenings;
    for (const auto& [parts, proposal] : proposals_) {
      if (proposal && proposal->log10_chance <= kSureToJoin)
        widenings.push_back(proposal->widening);
    }
    widening_ = Median(std::move(widenings), 1.0);
  }

  // Joins the two parts whose landmarks agree most surely: many nodes together find the few wrong
  // observations that two alone do not, so that every join makes the next one surer. False where
  // no two do.
  bool JoinSurestParts(double most_log10_chance) {
    ProposeJoins();
    const Proposal* surest = nullptr;
    for (const auto& [parts, proposal] : proposals_) {
      if (!proposal || proposal->log10_chance > most_log10_chance) continue;
      if (!surest || proposal->log10_chance < surest->log10_chance) surest = &*proposal;
    }
    if (!surest) return false;
    least_sure_ = std::max(least_sure_, surest->log10_chance);
    JoinParts(PartMotion(surest->motion));
    return true;
  }

  void JoinParts(const PartMotion& motion) {
    const int joined = std::min(motion.target, motion.source);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (component_[i] == motion.source) {
        nodes_[i].world_from_node = motion.target_from_source * nodes_[i].world_from_node;
        nodes_[i].fixed = false;
      }
      if (component_[i] == motion.source || component_[i] == motion.target) component_[i] = joined;
    }
    std::erase_if(proposals_, [&](const auto& entry) {
      const auto& [target, source] = entry.first;
      return target == motion.target || target == motion.source || source == motion.target ||
             source == motion.source;
    });
  }

  // What shares too few planes hangs on what else is known: odometry, as a rule.
  bool JoinByRelativePoses() {
    bool joined = false;
    for (const PoseFactor& factor : graph_.pose_factors) {
      if (factor.type != "relative_pose" || factor.robust) continue;
      PartMotion motion{factor.poses[0], factor.poses[1], Sim3(factor.measurement)};
      if (component_[motion.target] == component_[motion.source]) continue;
      if (!MayMove(component_[motion.source])) {
        motion = {motion.source, motion.target, motion.target_from_source.Inverse()};
      }
      if (!MayMove(component_[motion.source])) continue;
      JoinParts(BetweenParts(motion));
      joined = true;
    }
    return joined;
  }

  // The motion of the source's whole part that brings the two nodes into their relation.
  PartMotion BetweenParts(const PartMotion& motion) const {
    return {component_[motion.target], component_[motion.source],
            nodes_[motion.target].world_from_node * motion.target_from_source *
                nodes_[motion.source].world_from_node.Inverse()};
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
  std::map<std::pair<int, int>, std::optional<Proposal>> proposals_;  // by (target, source)
  double least_sure_ = kSureToJoin;               // log10 of the chance, of all that was joined
  double widening_ = 1.0;                         // of the stated deviations, as the pairs found it
  std::vector<NodeState> nodes_;                  // poses, then maps
  std::vector<int> component_;                    // by node
  std::vector<std::vector<int>> chosen_;          // by landmark: of its views
  std::vector<std::vector<NodePlane>> agreeing_;  // the same as planes
};

}  // namespace

JointInitialization InitializeJointly(Graph* graph, const JointInitializationOptions& options) {
  CheckGraph(*graph);
  if (graph->poses.empty() && graph->maps.empty()) return {{}, {}, {}, true, kSureToJoin};
  return Initializer(graph, options).Run();
}

}  // namespace planegraph
