#include "planegraph/pipeline/map_matching.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "pipeline/lap.h"
#include "planegraph/base/angles.h"
#include "planegraph/base/median.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/graph.h"

namespace planegraph {
namespace {

constexpr std::size_t kMostInGroup = 24;
constexpr double kLeastAgree = 0.1;     // of a scan's surfaces that the map must confirm
constexpr double kMostOff = 0.15;       // metres: walls and roofs are thicker
constexpr double kMostTurned = 0.0175;  // radians
constexpr double kFoundScaleSigma = 0.003;
constexpr double kMostSigma = 0.1;  // metres, of a registration that stands by itself

// The rigid motion nearest to a similarity about a point of the source.
Rigid3 RigidNear(const Sim3& similarity, const Eigen::Vector3d& about) {
  return {similarity.rotation, similarity * about - similarity.rotation * about};
}

// The scans of a component, thinned to kMostInGroup; the group's frame is the placement's present
// world.
struct Group {
  std::vector<std::size_t> scans;
  ScanGroup group;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

Group MakeGroup(const std::vector<ScanModel>& models, const std::vector<int>& component, int wanted,
                const std::vector<Rigid3>& poses) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < component.size(); ++i) {
    if (component[i] == wanted) members.push_back(i);
  }
  Group group;
  const std::size_t stride = 1 + (members.size() - 1) / kMostInGroup;
  for (std::size_t k = 0; k < members.size(); k += stride) {
    group.scans.push_back(members[k]);
    group.group.scans.push_back(&models[members[k]]);
    // Relative to the first scan: coordinates stay small, and the first scan stands for the group.
    group.group.group_from_scan.push_back(poses[members.front()].Inverse() * poses[members[k]]);
    group.centre += group.group.group_from_scan.back().translation;
  }
  group.centre /= static_cast<double>(group.scans.size());
  return group;
}

class Placer {
 public:
  Placer(const PlacementProblem& problem, Placement* placement)
      : problem_(problem), placement_(*placement), scale_known_(problem.maps.size(), false) {}

  void Run(std::vector<MapPairRecord>* records);

 private:
  std::optional<MapPrior::Pose> PresentPose(const Group& group) const;
  std::optional<MapPrior::Pose> StartPrior(const Group& group) const;
  std::optional<MapPrior::Pose> OdometryPrior(const Group& group) const;
  std::optional<MapPrior::Pose> GpsPrior(const Group& group) const;
  MapLocation Locate(const Group& group, std::size_t map) const;
  void Place(const Group& group, std::size_t map, const MapRefinement& found);
  void Tell(double share) const;
  void CorrectMap(const Group& group, std::size_t map, const Sim3& metric_from_group);

  const PlacementProblem& problem_;
  Placement& placement_;
  std::vector<bool> scale_known_;
  std::size_t done_ = 0, searches_ = 1;
};

// World pose of the group by a robot's start, if its first scan is in it.
std::optional<MapPrior::Pose> Placer::StartPrior(const Group& group) const {
  for (std::size_t k = 0; k < group.scans.size(); ++k) {
    const ScanRecord& scan = problem_.scans[group.scans[k]];
    const auto& start = problem_.site.robots[scan.robot].start;
    if (!IsFirstOfRobot(problem_.scans, group.scans[k]) || !start) continue;
    return MapPrior::Pose{start->world_from_scan * group.group.group_from_scan[k].Inverse(),
                          start->sigma_translation, start->sigma_rotation};
  }
  return {};
}

// World pose of the group by odometry from a scan that is placed already.
std::optional<MapPrior::Pose> Placer::OdometryPrior(const Group& group) const {
  constexpr double kLeastSigma = 0.3;  // metres
  for (const OdometryStep& step : problem_.odometry) {
    for (std::size_t k = 0; k < group.scans.size(); ++k) {
      const bool onward = step.source == group.scans[k] && placement_.placed[step.target];
      const bool back = step.target == group.scans[k] && placement_.placed[step.source];
      if (!onward && !back) continue;
      const Rigid3 world_from_scan =
          onward ? placement_.world_from_scan[step.target] * step.target_from_source
                 : placement_.world_from_scan[step.source] * step.target_from_source.Inverse();
      const double translation = std::sqrt(step.covariance.topLeftCorner<3, 3>().trace());
      const double rotation = std::sqrt(step.covariance.bottomRightCorner<3, 3>().trace());
      return MapPrior::Pose{world_from_scan * group.group.group_from_scan[k].Inverse(),
                            std::max(kLeastSigma, translation), rotation};
    }
  }
  return {};
}

// Roughly where the group is by the fix that is nearest to its first scan; its heading is open.
std::optional<MapPrior::Pose> Placer::GpsPrior(const Group& group) const {
  constexpr double kSigmas = 2.0;  // for the constant error and what outliers there are
  std::optional<MapPrior::Pose> best;
  for (const RobotPosition& fix : problem_.robot_positions) {
    const auto found = std::find(group.scans.begin(), group.scans.end(), fix.scan);
    if (found == group.scans.end()) continue;
    const std::size_t k = static_cast<std::size_t>(found - group.scans.begin());
    const double way = group.group.group_from_scan[k].translation.norm();
    const double sigma = std::hypot(kSigmas * fix.sigma, way + fix.antenna.norm());
    if (best && best->sigma_translation <= sigma) continue;
    best = MapPrior::Pose{{Eigen::Quaterniond::Identity(), fix.position}, sigma, std::numbers::pi};
  }
  return best;
}

// World pose of a group that another map has placed.
std::optional<MapPrior::Pose> Placer::PresentPose(const Group& group) const {
  constexpr double kSigma = 0.1, kSigmaRotation = 0.02;
  if (!placement_.placed[group.scans.front()]) return {};
  return MapPrior::Pose{placement_.world_from_scan[group.scans.front()], kSigma, kSigmaRotation};
}

MapLocation Placer::Locate(const Group& group, std::size_t m) const {
  const MapRecord& map = problem_.maps[m];
  MapLocationOptions options;
  options.threads = problem_.threads;
  options.progress = [this](double share) { Tell(share); };
  options.prior.upright = map.has_position();
  // A scale that another group has found is known far better than GPS tells, and elsewhere.
  if (scale_known_[m]) options.prior.scale = 1.0 / placement_.world_from_metric[m].scale;
  options.prior.sigma_scale = scale_known_[m] ? kFoundScaleSigma : map.sigma_scale;
  std::optional<MapPrior::Pose> pose = PresentPose(group);
  if (!pose) pose = OdometryPrior(group);
  if (!pose && map.has_position()) pose = StartPrior(group);
  if (!pose && map.has_position()) pose = GpsPrior(group);
  if (pose && map.has_position() && !scale_known_[m]) {
    // The receiver's constant bias is as large as what changes of its error.
    pose->sigma_translation =
        std::hypot(pose->sigma_translation,
                   std::max(map.georeference->sigma_horizontal, map.georeference->sigma_vertical));
  } else if (!scale_known_[m] && !map.has_position()) {
    pose.reset();  // a map without a place of its own
  }
  if (pose) {
    const Sim3 metric = placement_.world_from_metric[m].Inverse() * Sim3(pose->map_from_group);
    pose->map_from_group = RigidNear(metric, group.centre);
    options.prior.pose = pose;
  }
  return LocateInMap(problem_.map_models[m], group.group, options);
}

void Placer::Tell(double share) const {
  problem_.progress((static_cast<double>(done_) + share) / static_cast<double>(searches_));
}

// The laser is metric: the first group that is found in a map says what the map's metre is. The
// cameras' middle, the origin of the metric frame, stays where GPS has it; without GPS the map
// comes to where the robots are.
void Placer::CorrectMap(const Group& group, std::size_t m, const Sim3& metric_from_group) {
  if (scale_known_[m]) return;
  scale_known_[m] = true;
  Sim3& world_from_metric = placement_.world_from_metric[m];
  if (problem_.maps[m].has_position() && !placement_.placed[group.scans.front()]) {
    world_from_metric.scale = 1.0 / metric_from_group.scale;
    return;
  }
  const Rigid3& world_from_group = placement_.world_from_scan[group.scans.front()];
  world_from_metric = Sim3(world_from_group) * metric_from_group.Inverse();
}

void Placer::Place(const Group& group, std::size_t m, const MapRefinement& found) {
  CorrectMap(group, m, found.map_from_group);
  const Rigid3 world_from_group =
      RigidNear(placement_.world_from_metric[m] * found.map_from_group, group.centre);
  const Rigid3 moved = world_from_group * placement_.world_from_scan[group.scans.front()].Inverse();
  const int wanted = problem_.component[group.scans.front()];
  for (std::size_t i = 0; i < problem_.component.size(); ++i) {
    if (problem_.component[i] != wanted || placement_.placed[i]) continue;
    placement_.world_from_scan[i] = moved * placement_.world_from_scan[i];
    placement_.placed[i] = true;
  }
  if (found.residuals.size() > 100) placement_.errors[m] = MeasureMapErrors(found.residuals);
}

void Placer::Run(std::vector<MapPairRecord>* records) {
  // Components with a start first: what they find helps the others.
  std::set<int> components(problem_.component.begin(), problem_.component.end());
  std::vector<int> order(components.begin(), components.end());
  std::stable_partition(order.begin(), order.end(), [&](int c) {
    return StartPrior(MakeGroup(problem_.models, problem_.component, c, placement_.world_from_scan))
        .has_value();
  });
  searches_ = order.size() * problem_.maps.size();
  for (const int c : order) {
    for (std::size_t m = 0; m < problem_.maps.size(); ++m, ++done_) {
      const auto start = std::chrono::steady_clock::now();
      const Group group =
          MakeGroup(problem_.models, problem_.component, c, placement_.world_from_scan);
      if (placement_.placed[group.scans.front()] && scale_known_[m]) continue;
      const MapLocation location = Locate(group, m);
      if (location.status == RegistrationStatus::kOk) {
        Place(group, m, location.candidates.front().refinement);
        continue;
      }
      for (const std::size_t scan : group.scans) {
        MapPairRecord record;
        record.map = m;
        record.scan = scan;
        record.status = location.status;
        record.reason = location.reason;
        record.seconds = SecondsSince(start) / static_cast<double>(group.scans.size());
        records->push_back(std::move(record));
      }
    }
  }
}

// Planes of the scan that have a counterpart in the map.
std::size_t CountPlanes(const std::vector<PlanePair>& pairs) {
  std::set<std::int32_t> planes;
  for (const PlanePair& pair : pairs) planes.insert(pair.source);
  return planes.size();
}

void Decide(const Sim3& expected, MapPairRecord* record) {
  char text[160];
  const Sim3& found = record->refinement.map_from_group;
  const double off = (found.translation - expected.translation).norm();
  const double turned = AngleBetween(found.rotation, expected.rotation);
  const double sigma = std::sqrt(record->refinement.covariance.topLeftCorner<3, 3>().trace());
  if (record->evidence.agree < kLeastAgree) {
    std::snprintf(text, sizeof(text),
                  "not enough overlap: the map confirms %.0f %% of the surfaces",
                  100.0 * record->evidence.agree);
  } else if (sigma > kMostSigma) {
    record->status = RegistrationStatus::kDegenerate;
    std::snprintf(text, sizeof(text), "too little to stand by itself: sigma %.2f m", sigma);
  } else if (off > kMostOff || turned > kMostTurned) {
    std::snprintf(text, sizeof(text), "differs from the scan's group by %.2f m and %.2f deg", off,
                  turned * kDegreesPerRadian);
  } else {
    record->status = RegistrationStatus::kOk;
    record->used = true;
    return;
  }
  record->reason = text;
}

MapPairRecord RegisterToMap(const ScanModel& scan, const MapModel& map,
                            const Sim3& metric_from_scan) {
  const auto start = std::chrono::steady_clock::now();
  MapPairRecord record;
  const ScanGroup group(scan);
  MapRefinementOptions options;
  options.first_gate = 0.3;
  options.sigma_scale = 0.0;
  record.refinement = RefineInMap(map, group, metric_from_scan, options);
  const double gate = std::max(0.1, 5.0 * map.planes().noise.constant);
  record.evidence = MeasureEvidence(map, group, metric_from_scan, gate);
  record.correspondences =
      CountPlanes(MapCorrespondences(map, scan, record.refinement.map_from_group, gate));
  Decide(metric_from_scan, &record);
  record.seconds = SecondsSince(start);
  return record;
}

}  // namespace

void PlaceInMaps(const PlacementProblem& problem, Placement* placement,
                 std::vector<MapPairRecord>* records) {
  Placer(problem, placement).Run(records);
}

std::vector<MapPairRecord> RegisterToMaps(const std::vector<ScanModel>& models,
                                          const std::vector<MapModel>& map_models,
                                          const Placement& placement, int threads) {
  std::vector<std::pair<std::size_t, std::size_t>> jobs;
  for (std::size_t m = 0; m < map_models.size(); ++m) {
    for (std::size_t i = 0; i < models.size(); ++i) {
      if (placement.placed[i]) jobs.emplace_back(m, i);
    }
  }
  std::vector<MapPairRecord> records(jobs.size());
  ParallelFor(jobs.size(), threads, [&](std::size_t k) {
    const auto [m, i] = jobs[k];
    const Sim3 metric_from_scan =
        placement.world_from_metric[m].Inverse() * Sim3(placement.world_from_scan[i]);
    records[k] = RegisterToMap(models[i], map_models[m], metric_from_scan);
    records[k].map = m;
    records[k].scan = i;
  });
  return records;
}

double MapVarianceFactor(const std::vector<MapPairRecord>& records, const Placement& placement,
                         std::size_t map) {
  const Sim3 metric_from_world = placement.world_from_metric[map].Inverse();
  return MapVarianceFactor(records, map, [&](std::size_t scan) {
    return metric_from_world * Sim3(placement.world_from_scan[scan]);
  });
}

double MapVarianceFactor(const std::vector<MapPairRecord>& records, std::size_t map,
                         const std::function<Sim3(std::size_t scan)>& metric_from_scan) {
  constexpr double kUnknown = 4.0, kMedianOfChi2 = 0.891;  // six degrees of freedom, over six
  std::vector<double> ratios;
  for (const MapPairRecord& record : records) {
    if (!record.used || record.map != map) continue;
    const Sim3 expected = metric_from_scan(record.scan);
    const Sim3& found = record.refinement.map_from_group;
    Vector6d difference;
    difference << found.translation - expected.translation,
        LogSO3(found.rotation * expected.rotation.conjugate());
    const Matrix6d covariance = record.refinement.covariance.topLeftCorner<6, 6>();
    ratios.push_back(difference.dot(covariance.ldlt().solve(difference)) / 6.0);
  }
  if (ratios.size() < 3) return kUnknown;
  return std::max(1.0, Median(std::move(ratios)) / kMedianOfChi2);
}

}  // namespace planegraph
