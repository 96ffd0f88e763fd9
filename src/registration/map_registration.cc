#include "planegraph/registration/map_registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr double kLeastCosine = 0.94;
constexpr double kFirstGate = 0.8;      // metres: the vote's voxels
constexpr std::size_t kFirstLook = 96;  // samples, of all scans together
// Scans within the radius vote together; a long way votes from several places.
constexpr double kAnchorRadius = 6.0, kAnchorDistance = 12.0;  // metres
constexpr std::size_t kMostAnchors = 4;
constexpr double kMostScaleSigmas = 5.0;
constexpr double kSameMetres = 2.0, kSameRadians = 0.1;
constexpr double kPierceMargin = 0.7;  // metres that a beam must go on beyond a surface
constexpr double kViewRadius = 25.0;   // metres about a scan in which the map is looked through
constexpr std::size_t kMostViewed = 600;

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

// Counts of the map's surfels about one scan that its laser looked through, and that it met.
struct View {
  double pierced = 0.0, met = 0.0;
};

View LookThrough(const MapModel& map, const ScanModel& scan, const Sim3& map_from_scan) {
  View view;
  const auto section = map.Section(map_from_scan.translation, kViewRadius * map_from_scan.scale);
  const std::size_t stride = 1 + section.size() / kMostViewed;
  const Sim3 scan_from_map = map_from_scan.Inverse();
  for (std::size_t k = 0; k < section.size(); k += stride) {
    const Surfel& surfel = map.surfaces().surfels()[section[k]];
    // The back of a wall is hidden by its front; only what faces the scanner can be seen.
    if (surfel.normal.dot(map_from_scan.translation - surfel.mean) <= 0.0) continue;
    switch (scan.planes->range_image.Classify(scan_from_map * surfel.mean, kPierceMargin)) {
      case RangeImage::Space::kFree:
        view.pierced += surfel.area;
        break;
      case RangeImage::Space::kSurface:
        view.met += surfel.area;
        break;
      default:
        break;
    }
  }
  return view;
}

// What of one scan lies on the map, in sum and by direction.
struct Agreements {
  double agree = 0.0;
  Eigen::Matrix3d good = Eigen::Matrix3d::Zero(), all = Eigen::Matrix3d::Zero();
};

std::vector<Agreements> AgreementsByScan(const MapModel& map, const ScanGroup& group,
                                         const Sim3& map_from_group, double gate) {
  constexpr std::size_t kSamples = 256;
  std::vector<Agreements> scans(group.scans.size());
  const Eigen::Matrix3d rotation = map_from_group.rotation.toRotationMatrix();
  for (const GroupSample& s : SamplesOf(group, kSamples)) {
    const Eigen::Vector3d normal = rotation * s.normal;
    const Eigen::Matrix3d share = s.weight * normal * normal.transpose();
    scans[s.scan].all += share;
    if (map.surfaces().Find(map_from_group * s.mean, normal, gate, kLeastCosine) < 0) continue;
    scans[s.scan].good += share;
    scans[s.scan].agree += s.weight;
  }
  return scans;
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

void SortByScore(std::vector<MapCandidate>* candidates) {
  std::stable_sort(candidates->begin(), candidates->end(), [](const auto& a, const auto& b) {
    return a.evidence.Score() > b.evidence.Score();
  });
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
    return std::abs(std::log(c.refinement.map_from_group.scale)) > most;
  });
  SortByScore(&candidates);
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

// Refines the best candidate with more surfaces. One that falls behind the next by it leaves its
// place to that, until the first one is refined.
void RefineBest(const MapModel& map, const ScanGroup& group, const MapLocationOptions& options,
                std::vector<MapCandidate>* candidates) {
  MapRefinementOptions fine;
  fine.sigma_scale = options.prior.sigma_scale;
  fine.first_gate = 0.3;
  for (std::size_t k = 0; k < candidates->size(); ++k) {
    MapCandidate& best = candidates->front();
    best.refinement = RefineInMap(map, group, best.refinement.map_from_group, fine);
    best.evidence = MeasureEvidence(map, group, best.refinement.map_from_group, options.gate);
    const double score = best.evidence.Score();
    SortByScore(candidates);
    if (candidates->front().evidence.Score() <= score) return;
  }
}

// Probability that the best wrong pose scores as high as the best one: the scores of the poses that
// differ from it are a sample of wrong ones, and their upper tail is taken as exponential.
double ChanceOfWrong(const std::vector<MapCandidate>& candidates) {
  constexpr std::size_t kTail = 8;
  const std::size_t last = std::min(candidates.size() - 1, kTail);
  if (last < 3) return 0.0;  // nothing else fits at all
  const double second = candidates[1].evidence.Score();
  double excess = 0.0;
  for (std::size_t k = 1; k < last; ++k) {
    excess += (candidates[k].evidence.Score() - candidates[last].evidence.Score()) /
              static_cast<double>(last - 1);
  }
  const double lead = candidates[0].evidence.Score() - second;
  return excess > 0.0 ? std::exp(-lead / excess) : 0.0;
}

void Decide(const MapLocationOptions& options, MapLocation* location) {
  const MapEvidence& best = location->candidates.front().evidence;
  char text[160];
  if (location->r1 < options.least_score) {
    location->status = RegistrationStatus::kFailed;
    std::snprintf(
        text, sizeof(text),
        "the best place explains too little: %.0f %% of the surfaces, %.0f %% in the worst "
        "direction, score %.3f of %.3f",
        100.0 * best.agree, 100.0 * best.worst_direction, location->r1, options.least_score);
  } else if (location->r2 > options.ambiguity * location->r1 ||
             location->chance > options.most_chance) {
    location->status = RegistrationStatus::kAmbiguous;
    std::snprintf(text, sizeof(text),
                  "another place fits nearly as well: score %.3f and %.3f, chance of an error %.1e",
                  location->r2, location->r1, location->chance);
  } else {
    location->status = RegistrationStatus::kOk;
    return;
  }
  location->reason = text;
}

}  // namespace

MapEvidence MeasureEvidence(const MapModel& map, const ScanGroup& group, const Sim3& map_from_group,
                            double gate) {
  const std::vector<Agreements> scans = AgreementsByScan(map, group, map_from_group, gate);
  std::vector<std::size_t> order(scans.size());
  for (std::size_t s = 0; s < order.size(); ++s) order[s] = s;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scans[a].agree > scans[b].agree; });
  MapEvidence evidence;
  for (const Agreements& scan : scans) evidence.agree_by_scan.push_back(scan.agree);
  order.resize((scans.size() + 1) / 2);
  Eigen::Matrix3d good = Eigen::Matrix3d::Zero(), all = Eigen::Matrix3d::Zero();
  for (const std::size_t s : order) {
    evidence.agree += scans[s].agree / static_cast<double>(order.size());
    good += scans[s].good;
    all += scans[s].all;
  }
  const Eigen::Matrix3d floor = 0.02 * all.trace() * Eigen::Matrix3d::Identity();
  evidence.worst_direction = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d>(
                                 good + floor, all + floor, Eigen::EigenvaluesOnly)
                                 .eigenvalues()[0];
  View view;
  for (std::size_t s = 0; s < group.scans.size(); ++s) {
    const View one =
        LookThrough(map, *group.scans[s], map_from_group * Sim3(group.group_from_scan[s]));
    view.pierced += one.pierced;
    view.met += one.met;
  }
  if (view.pierced > 0.0) evidence.pierced = view.pierced / (view.pierced + view.met);
  return evidence;
}

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
  location.candidates = DifferentPoses(std::move(candidates), kMostCandidates);
  if (location.candidates.empty()) {
    location.reason = "the scans and the map have no two plane directions at equal angles";
    return location;
  }
  RefineBest(map, group, options, &location.candidates);
  location.r1 = location.candidates.front().evidence.Score();
  if (location.candidates.size() > 1) location.r2 = location.candidates[1].evidence.Score();
  location.chance = ChanceOfWrong(location.candidates);
  Decide(options, &location);
  return location;
}

}  // namespace planegraph
