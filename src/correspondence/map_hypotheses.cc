#include "planegraph/correspondence/map_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "correspondence/direction_grid.h"
#include "correspondence/rotation_hypotheses.h"
#include "planegraph/base/angles.h"
#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr std::size_t kMostRotations = 48;
constexpr double kHeadingStep = 6.0 * kDegree;
constexpr double kScaleStep = 0.025;  // of log(scale): half a voxel at a distance of 16 m
constexpr double kSigmas = 3.0;       // how far a prior is believed to be off
constexpr std::size_t kVotesPerRotation = 12;

double Tilt(const Eigen::Matrix3d& map_from_group) {
  return std::acos(std::clamp(map_from_group(2, 2), -1.0, 1.0));
}

bool Allowed(const MapPrior& prior, const Eigen::Matrix3d& rotation) {
  if (prior.upright && Tilt(rotation) > prior.most_tilt) return false;
  if (!prior.pose) return true;
  const double angle =
      AngleBetween(prior.pose->map_from_group.rotation, Eigen::Quaterniond(rotation));
  return angle <= std::sqrt(3.0) * kSigmas * prior.pose->sigma_rotation + 2.0 * kDegree;
}

// The group's vertical: of the directions within the tilt that is allowed the heaviest, the
// ground's.
Eigen::Vector3d UpOf(const std::vector<DirectionCluster>& directions, double most_tilt) {
  for (const auto& cluster : directions) {
    if (cluster.direction.z() > std::cos(most_tilt)) return cluster.direction;
  }
  return Eigen::Vector3d::UnitZ();
}

std::vector<Eigen::Matrix3d> Rotations(const MapModel& map, const ScanGroup& group,
                                       const MapPrior& prior) {
  const std::vector<DirectionCluster> directions = DirectionsOf(group);
  std::vector<Eigen::Matrix3d> rotations;
  const auto add = [&](const Eigen::Matrix3d& rotation) {
    if (Allowed(prior, rotation)) rotations.push_back(rotation);
  };
  for (const auto& r : FindRotations(map.directions(), directions, kMostRotations)) {
    add(r.target_from_source);
  }
  if (prior.pose) add(prior.pose->map_from_group.rotation.toRotationMatrix());
  if (!prior.upright) return rotations;
  const Eigen::Quaterniond level = Eigen::Quaterniond::FromTwoVectors(
      UpOf(directions, prior.most_tilt), Eigen::Vector3d::UnitZ());
  for (double heading = 0.0; heading < 2.0 * std::numbers::pi - 1e-9; heading += kHeadingStep) {
    add((ExpSO3({0.0, 0.0, heading}) * level).toRotationMatrix());
  }
  return rotations;
}

// Three standard deviations either way; of a scale that is hardly known two, in wider steps, for
// which the nearer surfaces of a scan vote.
std::vector<double> Scales(double about, double sigma) {
  constexpr double kHardlyKnown = 0.1;
  const double step = sigma > kHardlyKnown ? 2.0 * kScaleStep : kScaleStep;
  const double reach = (sigma > kHardlyKnown ? 2.0 : kSigmas) * sigma;
  const int steps = static_cast<int>(std::ceil(reach / step - 0.5));
  std::vector<double> scales;
  for (int k = -steps; k <= steps; ++k) scales.push_back(about * std::exp(k * step));
  return scales;
}

DirectionGrid::Window WindowOf(const MapModel& map, const MapPrior& prior) {
  // A scanner stands above the ground, possibly a little off the map's rim.
  constexpr double kRim = 5.0;
  const Eigen::Vector3d rim(kRim, kRim, kRim);
  DirectionGrid::Window window{map.grid().low() - Eigen::Vector3d(kRim, kRim, 0.0),
                               map.grid().high() + rim};
  if (!prior.pose) return window;
  const Eigen::Vector3d reach =
      Eigen::Vector3d::Constant(kSigmas * prior.pose->sigma_translation + map.grid().voxel());
  const Eigen::Vector3d low = prior.pose->map_from_group.translation - reach;
  const Eigen::Vector3d high = prior.pose->map_from_group.translation + reach;
  // Where hardly anything is known of the place, the map's extent is the smaller window.
  if ((high - low).maxCoeff() < (window.high - window.low).maxCoeff()) return {low, high};
  return {low.cwiseMax(window.low), high.cwiseMin(window.high)};
}

// The samples as voters of a body that is turned; at scale 1.
std::vector<DirectionGrid::Voter> Voters(const std::vector<GroupSample>& samples,
                                         const Eigen::Matrix3d& rotation) {
  std::vector<DirectionGrid::Voter> voters;
  for (const GroupSample& s : samples) {
    voters.push_back({rotation * s.mean, DirectionGrid::ClassOf(rotation * s.normal)});
  }
  return voters;
}

}  // namespace

std::vector<MapHypothesis> FindMapHypotheses(const MapModel& map, const ScanGroup& group,
                                             const MapPrior& prior, std::size_t most, int threads) {
  if (map.surfaces().surfels().empty()) return {};
  const auto samples = SamplesOf(group, std::max<std::size_t>(1, kMapVoters / group.scans.size()));
  const auto rotations = Rotations(map, group, prior);
  const auto scales = Scales(prior.scale, prior.sigma_scale);
  const auto window = WindowOf(map, prior);
  std::vector<std::vector<MapHypothesis>> found(rotations.size() * scales.size());
  std::vector<std::vector<DirectionGrid::Voter>> turned(rotations.size());
  ParallelFor(rotations.size(), threads,
              [&](std::size_t k) { turned[k] = Voters(samples, rotations[k]); });
  ParallelFor(found.size(), threads, [&](std::size_t k) {
    const Eigen::Matrix3d& rotation = rotations[k / scales.size()];
    const double scale = scales[k % scales.size()];
    auto voters = turned[k / scales.size()];
    for (auto& voter : voters) voter.place *= scale;
    for (const auto& vote : map.grid().Count(voters, window, kVotesPerRotation)) {
      found[k].push_back({Sim3(scale, Eigen::Quaterniond(rotation), vote.translation), vote.count});
    }
  });
  std::vector<MapHypothesis> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.votes > b.votes; });
  if (all.size() > most) all.resize(most);
  return all;
}

}  // namespace planegraph
