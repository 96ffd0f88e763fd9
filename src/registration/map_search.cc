#include "registration/map_search.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"
#include "registration/map_word.h"

namespace planegraph {
namespace {

constexpr double kFirstGate = 0.8;      // metres: the vote's voxels
constexpr std::size_t kFirstLook = 96;  // samples, of all scans together
// Scans within the radius vote together; a long way votes from several places.
constexpr double kAnchorRadius = 6.0, kAnchorDistance = 12.0;  // metres
constexpr std::size_t kMostAnchors = 4;
// metres: candidates are told apart by it; the best one is refined further
constexpr double kRest = 0.002;
// When the gate has come to its least, starts this near to each other end at the same place: a
// small part of the gate.
constexpr double kSameStartMetres = 0.03, kSameStartRadians = 0.003;  // and of log(scale)
constexpr double kMostScaleSigmas = 5.0;

constexpr double kShareOfVotes = 0.5;  // of the search's time, about; the rest is refinement

// Share of agreement, quickly: for a first look at many hypotheses.
double Agreement(const MapModel& map, const std::vector<GroupSample>& samples, const Sim3& pose,
                 double gate) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  double agree = 0.0, all = 0.0;
  for (const GroupSample& s : samples) {
    const Eigen::Vector3d place = pose.scale * (rotation * s.mean) + pose.translation;
    all += s.weight;
    if (map.surfaces().Find(place, rotation * s.normal, gate, kSameFacing) >= 0) agree += s.weight;
  }
  return all > 0.0 ? agree / all : 0.0;
}

std::vector<Sim3> FirstLook(const MapModel& map, const ScanGroup& group, const MapPrior& prior,
                            std::size_t most, const MapLocationOptions& options) {
  const auto hypotheses =
      FindMapHypotheses(map, group, prior, options.most_hypotheses, options.threads);
  const auto samples = SamplesOf(group, std::max<std::size_t>(8, kFirstLook / group.scans.size()));
  std::vector<double> scores(hypotheses.size());
  ParallelFor(hypotheses.size(), options.threads, [&](std::size_t i) {
    scores[i] = Agreement(map, samples, hypotheses[i].map_from_group, kFirstGate);
  });
  std::vector<std::size_t> order(hypotheses.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  std::vector<Sim3> kept;
  for (const std::size_t i : order) {
    if (kept.size() == most) break;
    kept.push_back(hypotheses[i].map_from_group);
  }
  return kept;
}

// What a prior of the group's pose says of one of its scans: the rotation's error has a lever arm.
MapPrior PriorOf(const MapPrior& prior, const Rigid3& group_from_anchor) {
  MapPrior moved = prior;
  if (!prior.pose) return moved;
  moved.pose->map_from_group = prior.pose->map_from_group * group_from_anchor;
  moved.pose->sigma_translation =
      std::hypot(prior.pose->sigma_translation,
                 prior.pose->sigma_rotation * group_from_anchor.translation.norm());
  return moved;
}

// A start for refinement: some scans of the group, laid onto the map.
struct Start {
  std::size_t anchor;
  Sim3 map_from_anchor;
};

// The votes are those of scans that stand close together: over a long way a rotation that is off by
// a degree takes the other end elsewhere.
std::vector<Start> FindStarts(const MapModel& map, const ScanGroup& group,
                              const MapLocationOptions& options) {
  const auto anchors = Anchors(group, kAnchorDistance, kMostAnchors);
  const std::size_t most = std::max<std::size_t>(12, options.most_refined / anchors.size());
  std::vector<Start> starts;
  for (std::size_t k = 0; k < anchors.size(); ++k) {
    const std::size_t anchor = anchors[k];
    const MapPrior prior = PriorOf(options.prior, group.group_from_scan[anchor]);
    for (const Sim3& pose :
         FirstLook(map, Around(group, anchor, kAnchorRadius), prior, most, options)) {
      starts.push_back({anchor, pose});
    }
    options.progress(kShareOfVotes * static_cast<double>(k + 1) /
                     static_cast<double>(anchors.size()));
  }
  return starts;
}

MapRefinementOptions QuickRefinement(const MapPrior& prior) {
  MapRefinementOptions quick;
  quick.scale = prior.scale;
  quick.sigma_scale = prior.sigma_scale;
  quick.most_surfels = 400;
  quick.pose_only = true;
  quick.rest = kRest;
  return quick;
}

// Steps until the gate has come to its least.
int StepsOfApproach(const MapRefinementOptions& options) {
  return static_cast<int>(std::ceil(std::log(options.last_gate / options.first_gate) /
                                    std::log(MapRefinementOptions::kNarrowing)));
}

// The first steps, by the scans about the anchor, until the gate is at its least.
void Approach(const MapModel& map, const ScanGroup& group, const MapLocationOptions& options,
              Start* start) {
  MapRefinementOptions quick = QuickRefinement(options.prior);
  quick.most_iterations = StepsOfApproach(quick);
  start->map_from_anchor =
      RefineInMap(map, Around(group, start->anchor, kAnchorRadius), start->map_from_anchor, quick)
          .map_from_group;
}

// Refines by the scans about the anchor first, then by all.
MapCandidate RefineFrom(const MapModel& map, const ScanGroup& group, const Start& start,
                        const MapLocationOptions& options) {
  MapRefinementOptions quick = QuickRefinement(options.prior);
  MapRefinementOptions rest = quick;
  rest.first_gate = quick.last_gate;
  rest.most_iterations -= StepsOfApproach(quick);
  MapCandidate candidate;
  const ScanGroup around = Around(group, start.anchor, kAnchorRadius);
  candidate.refinement = RefineInMap(map, around, start.map_from_anchor, rest);
  candidate.refinement.map_from_group =
      candidate.refinement.map_from_group * Sim3(group.group_from_scan[start.anchor].Inverse());
  if (around.scans.size() < group.scans.size()) {
    candidate.refinement = RefineInMap(map, group, candidate.refinement.map_from_group, quick);
  }
  candidate.evidence =
      MeasureEvidence(map, group, candidate.refinement.map_from_group, options.gate);
  return candidate;
}

// Of each start the first one that is as good as the same: most votes are for few places.
std::vector<std::size_t> FirstOfSame(const std::vector<Start>& starts) {
  std::vector<std::size_t> first(starts.size());
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto same = [&](const Start& other) {
      const Sim3 &a = starts[i].map_from_anchor, &b = other.map_from_anchor;
      return starts[i].anchor == other.anchor &&
             (a.translation - b.translation).norm() < kSameStartMetres &&
             AngleBetween(a.rotation, b.rotation) < kSameStartRadians &&
             std::abs(std::log(a.scale / b.scale)) < kSameStartRadians;
    };
    first[i] =
        static_cast<std::size_t>(std::find_if(starts.begin(), starts.end(), same) - starts.begin());
  }
  return first;
}

}  // namespace

std::vector<MapCandidate> SearchMap(const MapModel& map, const ScanGroup& group,
                                    const MapLocationOptions& options) {
  std::vector<Start> starts = FindStarts(map, group, options);
  std::atomic<std::size_t> done{0};
  const auto tell = [&] {
    const double share = 0.5 * static_cast<double>(++done) / static_cast<double>(starts.size());
    options.progress(kShareOfVotes + (1.0 - kShareOfVotes) * share);
  };
  ParallelFor(starts.size(), options.threads, [&](std::size_t i) {
    Approach(map, group, options, &starts[i]);
    tell();
  });
  const std::vector<std::size_t> first = FirstOfSame(starts);
  std::vector<MapCandidate> candidates(starts.size());
  ParallelFor(starts.size(), options.threads, [&](std::size_t i) {
    if (first[i] == i) candidates[i] = RefineFrom(map, group, starts[i], options);
    tell();
  });
  // Each counts as before: how often a place is met is part of what is known of wrong ones.
  for (std::size_t i = 0; i < starts.size(); ++i) candidates[i] = candidates[first[i]];
  // Where nothing fits, the surfaces pull the scale to where no prior would have it.
  const double most = kMostScaleSigmas * std::max(options.prior.sigma_scale, 0.005);
  std::erase_if(candidates, [&](const MapCandidate& c) {
    return std::abs(std::log(c.refinement.map_from_group.scale / options.prior.scale)) > most;
  });
  return candidates;
}

}  // namespace planegraph
