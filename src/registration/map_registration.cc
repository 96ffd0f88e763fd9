#include "planegraph/registration/map_registration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "correspondence/direction_grid.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"
#include "registration/map_slides.h"
#include "registration/start_prior.h"

namespace planegraph {
namespace {

constexpr double kLeastCosine = 0.94;
constexpr double kFirstGate = 0.8;      // metres: the vote's voxels
constexpr std::size_t kFirstLook = 96;  // samples, of all scans together
// Scans within the radius vote together; a long way votes from several places.
constexpr double kAnchorRadius = 6.0, kAnchorDistance = 12.0;  // metres
constexpr std::size_t kMostAnchors = 4;
constexpr double kMostScaleSigmas = 5.0;
constexpr double kFirstBackground = 0.3;  // to find the best candidate, and so all others
constexpr double kSameMetres = 2.0, kSameRadians = 0.1;

// Share of agreement, quickly: for a first look at many hypotheses.
double Agreement(const MapModel& map, const std::vector<GroupSample>& samples, const Sim3& pose,
                 double gate) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  double agree = 0.0, all = 0.0;
  for (const GroupSample& s : samples) {
    const Eigen::Vector3d place = pose.scale * (rotation * s.mean) + pose.translation;
    all += s.weight;
    if (map.surfaces().Find(place, rotation * s.normal, gate, kLeastCosine) >= 0) agree += s.weight;
  }
  return all > 0.0 ? agree / all : 0.0;
}

bool SamePose(const Sim3& a, const Sim3& b) {
  return (a.translation - b.translation).norm() < kSameMetres &&
         AngleBetween(a.rotation, b.rotation) < kSameRadians;
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
  for (const std::size_t anchor : anchors) {
    const MapPrior prior = PriorOf(options.prior, group.group_from_scan[anchor]);
    for (const Sim3& pose :
         FirstLook(map, Around(group, anchor, kAnchorRadius), prior, most, options)) {
      starts.push_back({anchor, pose});
    }
  }
  return starts;
}

// Refines by the scans about the anchor first, then by all.
MapCandidate RefineFrom(const MapModel& map, const ScanGroup& group, const Start& start,
                        const MapLocationOptions& options) {
  MapRefinementOptions quick;
  quick.scale = options.prior.scale;
  quick.sigma_scale = options.prior.sigma_scale;
  quick.most_surfels = 400;
  MapCandidate candidate;
  const ScanGroup around = Around(group, start.anchor, kAnchorRadius);
  candidate.refinement = RefineInMap(map, around, start.map_from_anchor, quick);
  candidate.refinement.map_from_group =
      candidate.refinement.map_from_group * Sim3(group.group_from_scan[start.anchor].Inverse());
  if (around.scans.size() < group.scans.size()) {
    candidate.refinement = RefineInMap(map, group, candidate.refinement.map_from_group, quick);
  }
  candidate.evidence =
      MeasureEvidence(map, group, candidate.refinement.map_from_group, options.gate);
  return candidate;
}

// Of its evidence and of the start.
double LogPosterior(const MapCandidate& c) { return c.log_likelihood + c.log_prior; }

// What is believed of a candidate, by its present pose and evidence.
void Weigh(const MapModel& map, const MapPrior& prior, double background, MapCandidate* c) {
  const Eigen::Vector3d extent = map.grid().high() - map.grid().low();
  c->log_likelihood = LogLikelihoodRatio(c->evidence, background);
  c->log_prior = LogStartRatio(extent, prior, c->refinement.map_from_group);
}

void SortBest(const MapModel& map, const MapPrior& prior, double background,
              std::vector<MapCandidate>* candidates) {
  for (MapCandidate& c : *candidates) Weigh(map, prior, background, &c);
  std::stable_sort(candidates->begin(), candidates->end(),
                   [](const auto& a, const auto& b) { return LogPosterior(a) > LogPosterior(b); });
}

// What wrong poses of this search look like: all but those near the best one.
double BackgroundOf(const std::vector<MapCandidate>& candidates) {
  std::vector<const MapEvidence*> wrong;
  for (const MapCandidate& c : candidates) {
    if (!SamePose(c.refinement.map_from_group, candidates.front().refinement.map_from_group)) {
      wrong.push_back(&c.evidence);
    }
  }
  return BackgroundShare(wrong);
}

std::vector<MapCandidate> RefineAll(const MapModel& map, const ScanGroup& group,
                                    const std::vector<Start>& starts,
                                    const MapLocationOptions& options) {
  std::vector<MapCandidate> candidates(starts.size());
  ParallelFor(starts.size(), options.threads,
              [&](std::size_t i) { candidates[i] = RefineFrom(map, group, starts[i], options); });
  // Where nothing fits, the surfaces pull the scale to where no prior would have it.
  const double most = kMostScaleSigmas * std::max(options.prior.sigma_scale, 0.005);
  std::erase_if(candidates, [&](const MapCandidate& c) {
    return std::abs(std::log(c.refinement.map_from_group.scale / options.prior.scale)) > most;
  });
  return candidates;
}

std::vector<MapCandidate> DifferentPoses(std::vector<MapCandidate> candidates, std::size_t most) {
  std::vector<MapCandidate> kept;
  for (auto& candidate : candidates) {
    if (kept.size() == most) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const MapCandidate& k) {
      return SamePose(k.refinement.map_from_group, candidate.refinement.map_from_group);
    });
    if (!known) kept.push_back(std::move(candidate));
  }
  return kept;
}

// A candidate, refined with more surfaces from a pose near its own.
MapCandidate RefineFinely(const MapModel& map, const ScanGroup& group, const Sim3& pose,
                          const MapLocationOptions& options, double background) {
  MapRefinementOptions fine;
  fine.scale = options.prior.scale;
  fine.sigma_scale = options.prior.sigma_scale;
  fine.first_gate = 0.3;
  MapCandidate candidate;
  candidate.refinement = RefineInMap(map, group, pose, fine);
  candidate.evidence =
      MeasureEvidence(map, group, candidate.refinement.map_from_group, options.gate);
  Weigh(map, options.prior, background, &candidate);
  return candidate;
}

// Refines the best candidate. One that falls behind the next by it leaves its place to that, until
// the first one is refined.
void RefineBest(const MapModel& map, const ScanGroup& group, const MapLocationOptions& options,
                double background, std::vector<MapCandidate>* candidates) {
  for (std::size_t k = 0; k < candidates->size(); ++k) {
    MapCandidate& best = candidates->front();
    best = RefineFinely(map, group, best.refinement.map_from_group, options, background);
    const double posterior = LogPosterior(best);
    SortBest(map, options.prior, background, candidates);
    if (LogPosterior(candidates->front()) <= posterior) return;
  }
}

// The rival closest to the best candidate, which goes to it while that is the better one.
Slide SlideBest(const MapModel& map, const ScanGroup& group, const MapLocationOptions& options,
                double background, MapCandidate* best) {
  constexpr int kMostMoves = 2;
  Slide slide = ClosestSlide(map, group, best->refinement, options.gate);
  for (int k = 0; k < kMostMoves && slide.lead < 0.0; ++k) {
    MapCandidate moved = RefineFinely(map, group, slide.map_from_group, options, background);
    const Slide next = ClosestSlide(map, group, moved.refinement, options.gate);
    if (next.lead <= slide.lead) break;
    *best = std::move(moved);
    slide = next;
  }
  return slide;
}

// Each candidate may be where the scans stand, with what the start says of it as prior probability,
// and they may as well stand nowhere in the map, where every pose is of the background.
void ComputeProbabilities(const Slide& slide, MapLocation* location) {
  auto& candidates = location->candidates;
  const double top = std::max(0.0, LogPosterior(candidates.front()));
  for (MapCandidate& c : candidates) c.probability = std::exp(LogPosterior(c) - top);
  location->nowhere = static_cast<double>(candidates.size()) * std::exp(-top);
  location->slid = candidates.front().probability * std::exp(-std::max(0.0, slide.lead));
  double wrong = location->nowhere + location->slid;
  for (std::size_t k = 1; k < candidates.size(); ++k) wrong += candidates[k].probability;
  const double all = candidates.front().probability + wrong;
  for (MapCandidate& c : candidates) c.probability /= all;
  location->chance = wrong / all;
  location->nowhere /= all;
  location->slid /= all;
  location->r1 = candidates[0].probability;
  if (candidates.size() > 1) location->r2 = candidates[1].probability;
}

std::string ReasonOf(const MapLocation& location, double most_chance, double slid_metres) {
  const MapEvidence& best = location.candidates.front().evidence;
  char text[200];
  if (location.nowhere > most_chance) {
    std::snprintf(text, sizeof(text),
                  "chance could have made the best place: the map confirms %.0f %% of the surfaces "
                  "and contradicts %.0f %%, probability of an error %.1e",
                  100.0 * best.confirmed, 100.0 * best.contradicted, location.chance);
  } else if (location.slid > location.r2) {
    std::snprintf(text, sizeof(text),
                  "%.2f m beside it the best place fits nearly as well: probability %.4f",
                  slid_metres, location.slid);
  } else {
    std::snprintf(text, sizeof(text),
                  "another place fits nearly as well: probabilities %.4f and %.4f", location.r1,
                  location.r2);
  }
  return text;
}

void Decide(const MapLocationOptions& options, const Slide& slide, MapLocation* location) {
  if (location->chance <= options.most_chance) {
    location->status = RegistrationStatus::kOk;
    return;
  }
  location->status = location->nowhere > options.most_chance ? RegistrationStatus::kFailed
                                                             : RegistrationStatus::kAmbiguous;
  location->reason = ReasonOf(*location, options.most_chance, slide.metres);
}

}  // namespace

std::vector<PlanePair> MapCorrespondences(const MapModel& map, const ScanModel& scan,
                                          const Sim3& map_from_scan, double gate) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> counts;
  const Eigen::Matrix3d rotation = map_from_scan.rotation.toRotationMatrix();
  for (const Surfel& surfel : scan.map.surfels()) {
    if (surfel.segment < 0) continue;
    const int found = map.surfaces().Find(map_from_scan * surfel.mean, rotation * surfel.normal,
                                          gate, kLeastCosine);
    if (found < 0) continue;
    const std::int32_t segment = map.surfaces().surfels()[found].segment;
    if (segment >= 0) counts[{segment, surfel.segment}]++;
  }
  std::vector<PlanePair> pairs;
  for (const auto& [planes, count] : counts) {
    if (count >= 2) pairs.push_back({planes.first, planes.second, count});
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const auto& a, const auto& b) { return a.surfels > b.surfels; });
  return pairs;
}

MapLocation LocateInMap(const MapModel& map, const ScanGroup& group,
                        const MapLocationOptions& given) {
  constexpr std::size_t kMostCandidates = 12;
  MapLocationOptions options = given;
  options.gate = std::max(given.gate, 5.0 * map.planes().noise.constant);
  MapLocation location;
  auto candidates = RefineAll(map, group, FindStarts(map, group, options), options);
  if (candidates.empty()) {
    location.reason = "the scans and the map have no two plane directions at equal angles";
    return location;
  }
  SortBest(map, options.prior, kFirstBackground, &candidates);
  location.background = BackgroundOf(candidates);
  SortBest(map, options.prior, location.background, &candidates);
  location.candidates = DifferentPoses(std::move(candidates), kMostCandidates);
  RefineBest(map, group, options, location.background, &location.candidates);
  const Slide slide =
      SlideBest(map, group, options, location.background, &location.candidates.front());
  ComputeProbabilities(slide, &location);
  Decide(options, slide, &location);
  return location;
}

}  // namespace planegraph
