#include "planegraph/registration/map_registration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "correspondence/direction_grid.h"
#include "planegraph/geometry/rotation.h"
#include "registration/map_search.h"
#include "registration/map_slides.h"
#include "registration/map_word.h"
#include "registration/start_prior.h"

namespace planegraph {
namespace {

constexpr double kFirstBackground = 0.3;  // to find the best candidate, and so all others
constexpr double kNearMetres = 2.0, kNearRadians = 0.1;

bool SamePose(const Sim3& a, const Sim3& b) {
  return (a.translation - b.translation).norm() < kNearMetres &&
         AngleBetween(a.rotation, b.rotation) < kNearRadians;
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
  for (int k = 0; k < kMostMoves && slide.lead_of_all < 0.0; ++k) {
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
  location->slid = {slide.direction, slide.metres,
                    candidates.front().probability * std::exp(-std::max(0.0, slide.lead))};
  double wrong = location->nowhere + location->slid.probability;
  for (std::size_t k = 1; k < candidates.size(); ++k) wrong += candidates[k].probability;
  const double all = candidates.front().probability + wrong;
  for (MapCandidate& c : candidates) c.probability /= all;
  location->chance = wrong / all;
  location->nowhere /= all;
  location->slid.probability /= all;
  location->r1 = candidates[0].probability;
  if (candidates.size() > 1) location->r2 = candidates[1].probability;
}

std::string ReasonOf(const MapLocation& location, double most_chance) {
  const MapEvidence& best = location.candidates.front().evidence;
  char text[200];
  if (location.nowhere > most_chance) {
    std::snprintf(text, sizeof(text),
                  "chance could have made the best place: the map confirms %.0f %% of the surfaces "
                  "and contradicts %.0f %%, probability of an error %.1e",
                  100.0 * best.confirmed, 100.0 * best.contradicted, location.chance);
  } else if (const MapSlide& slid = location.slid; slid.probability > location.r2) {
    std::snprintf(text, sizeof(text),
                  "%.2f m beside it, along (%.2f, %.2f, %.2f), the best place fits nearly as well: "
                  "probability %.4f",
                  slid.metres, slid.direction.x(), slid.direction.y(), slid.direction.z(),
                  slid.probability);
  } else {
    std::snprintf(text, sizeof(text),
                  "another place fits nearly as well: probabilities %.4f and %.4f", location.r1,
                  location.r2);
  }
  return text;
}

void Decide(const MapLocationOptions& options, MapLocation* location) {
  if (location->chance <= options.most_chance) {
    location->status = RegistrationStatus::kOk;
    return;
  }
  location->status = location->nowhere > options.most_chance ? RegistrationStatus::kFailed
                                                             : RegistrationStatus::kAmbiguous;
  location->reason = ReasonOf(*location, options.most_chance);
}

}  // namespace

std::vector<PlanePair> MapCorrespondences(const MapModel& map, const ScanModel& scan,
                                          const Sim3& map_from_scan, double gate) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> counts;
  const Eigen::Matrix3d rotation = map_from_scan.rotation.toRotationMatrix();
  for (const Surfel& surfel : scan.map.surfels()) {
    if (surfel.segment < 0) continue;
    const int found = map.surfaces().Find(map_from_scan * surfel.mean, rotation * surfel.normal,
                                          gate, kSameFacing);
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
  auto candidates = SearchMap(map, group, options);
  if (candidates.empty()) {
    location.reason =
        options.prior.pose
            ? "near the start no two plane directions of the scans and the map are at equal "
              "angles: is its rotation x y z w, and in the frame of the map (east, north, up)?"
            : "the scans and the map have no two plane directions at equal angles";
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
  Decide(options, &location);
  return location;
}

}  // namespace planegraph
