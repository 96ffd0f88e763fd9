#include "locate/outcome.h"

#include <algorithm>

#include "planegraph/base/angles.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/registration/cell_search.h"
#include "thread_seconds.h"

namespace planegraph {
namespace {

constexpr double kRightMetres = 1.0, kRightDegrees = 5.0;

struct Error {
  double metres, degrees;
  bool near() const { return metres <= kRightMetres && degrees <= kRightDegrees; }
};

// Of a scan's pose in the map, measured in the world through the true similarity: a wrong scale of
// the map by GPS is no error of the place.
Error ErrorOf(const LocatedSite& site, std::size_t scan, const Sim3& metric_from_scan) {
  const Sim3 found = site.world_from_map * site.map.metric_from_map.Inverse() * metric_from_scan;
  const Rigid3& truth = site.world_from_scan[scan];
  return {(found.translation - truth.translation).norm(),
          AngleBetween(found.rotation, truth.rotation) / kDegree};
}

void Judge(const LocatedSite& site, const MapLocation& location, Outcome* outcome) {
  outcome->status = location.status;
  outcome->reason = location.reason;
  outcome->chance = location.chance;
  outcome->nowhere = location.nowhere;
  for (std::size_t k = 0; k < location.candidates.size(); ++k) {
    const MapCandidate& candidate = location.candidates[k];
    const Error error = ErrorOf(site, outcome->scan, candidate.refinement.map_from_group);
    if (k == 0) {
      outcome->metres = error.metres;
      outcome->degrees = error.degrees;
      outcome->near = error.near();
      outcome->best = candidate.log_likelihood;
      outcome->confirmed = candidate.evidence.confirmed;
      outcome->contradicted = candidate.evidence.contradicted;
    }
    if (!error.near())
      outcome->wrong_pose = std::max(outcome->wrong_pose, candidate.log_likelihood);
  }
}

MapLocationOptions OptionsFor(const LocatedSite& site) {
  MapLocationOptions options;
  options.prior.sigma_scale = site.map.sigma_scale;
  options.prior.upright = site.map.has_position();
  return options;
}

// The log-likelihood ratio that LocateInMap would find at the true place.
double TrueLikelihood(const LocatedSite& site, const MapModel& map, const ScanGroup& group,
                      std::size_t scan, double background) {
  const MapLocationOptions options = OptionsFor(site);
  MapRefinementOptions refinement;
  refinement.sigma_scale = options.prior.sigma_scale;
  refinement.first_gate = 0.3;
  const Sim3 pose = RefineInMap(map, group, site.MetricFromScan(scan), refinement).map_from_group;
  const double gate = std::max(options.gate, 5.0 * map.planes().noise.constant);
  return LogLikelihoodRatio(MeasureEvidence(map, group, pose, gate), background);
}

Outcome Locate(const LocatedSite& site, const MapModel& map, const ScanGroup& group,
               std::size_t scan) {
  Outcome outcome;
  outcome.scan = scan;
  outcome.scans = group.scans.size();
  double coverage = 0.0;
  for (std::size_t k = 0; k < outcome.scans; ++k) coverage += site.coverage[scan + k];
  outcome.covered = coverage >= 0.5 * static_cast<double>(outcome.scans);
  const double start = ThreadSeconds();
  const MapLocation location = LocateInMap(map, group, OptionsFor(site));
  outcome.seconds = ThreadSeconds() - start;
  Judge(site, location, &outcome);
  outcome.truth = TrueLikelihood(site, map, group, scan, location.background);
  return outcome;
}

Rigid3 Step(const LocatedSite& site, const ScanModel& target, const ScanModel& source,
            std::size_t scan) {
  const ScanRecord& record = site.scans[scan];
  const auto& odometry = site.site.robots[record.robot].odometry->poses;
  const Rigid3 guess = odometry[record.index].Inverse() * odometry[record.index + 1];
  const PosePrior weak{guess, 1e4 * Matrix6d::Identity()};
  const Registration found = RegisterFromGuess(target, source, weak);
  return found.status == RegistrationStatus::kOk ? found.target_from_source() : guess;
}

bool HasNext(const LocatedSite& site, std::size_t scan) {
  return scan + 1 < site.scans.size() && site.scans[scan + 1].robot == site.scans[scan].robot &&
         site.site.robots[site.scans[scan].robot].odometry.has_value();
}

}  // namespace

std::vector<Outcome> LocateAlone(const LocatedSite& site, int threads) {
  const MapModel map(site.map.planes);
  std::vector<Outcome> outcomes(site.scans.size());
  ParallelFor(outcomes.size(), threads, [&](std::size_t k) {
    const ScanModel model(site.scans[k].planes);
    outcomes[k] = Locate(site, map, ScanGroup(model), k);
  });
  return outcomes;
}

std::vector<Outcome> LocateInPairs(const LocatedSite& site, int threads) {
  const MapModel map(site.map.planes);
  std::vector<std::size_t> firsts;
  for (std::size_t k = 0; k < site.scans.size(); ++k) {
    if (HasNext(site, k)) firsts.push_back(k);
  }
  std::vector<Outcome> outcomes(firsts.size());
  ParallelFor(outcomes.size(), threads, [&](std::size_t k) {
    const ScanModel first(site.scans[firsts[k]].planes), second(site.scans[firsts[k] + 1].planes);
    ScanGroup group(first);
    group.scans.push_back(&second);
    group.group_from_scan.push_back(Step(site, first, second, firsts[k]));
    outcomes[k] = Locate(site, map, group, firsts[k]);
  });
  return outcomes;
}

std::vector<Outcome> LocateInCells(const LocatedSite& site, int threads) {
  std::vector<Outcome> outcomes(site.scans.size());
  ParallelFor(outcomes.size(), threads, [&](std::size_t k) {
    outcomes[k].scan = k;
    outcomes[k].covered = site.Covered(k);
    const double start = ThreadSeconds();
    Judge(site, LocateByCells(site.map.planes, site.scans[k].planes), &outcomes[k]);
    outcomes[k].seconds = ThreadSeconds() - start;
  });
  return outcomes;
}

}  // namespace planegraph
