#include "planegraph/registration/map_refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "planegraph/base/median.h"
#include "planegraph/geometry/cube_side.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// From this gate on the association is good enough to measure how well surfaces agree.
constexpr double kMapCalibrationGate = 0.3;
// Information that stands for none: a standard deviation of a kilometre, or of 1000 radians.
constexpr double kMapRidge = 1e-6;
constexpr double kLeastFloor = 0.005;  // metres

// The median of squares of a normal distribution is 0.455 of its variance.
double RobustVariance(const std::vector<MapResidual>& residuals) {
  std::vector<double> squares;
  for (const auto& r : residuals) squares.push_back(r.height * r.height);
  return Median(std::move(squares)) / 0.455;
}

double MedianVariance(const std::vector<MapResidual>& residuals) {
  std::vector<double> variances;
  for (const auto& r : residuals) variances.push_back(r.variance);
  return Median(std::move(variances));
}

// Surfels of the group to be laid onto the map, evenly over the scans.
std::vector<GroupSample> Surfels(const ScanGroup& group, std::size_t most) {
  std::size_t total = 0;
  for (const ScanModel* scan : group.scans) total += scan->map.surfels().size();
  const std::size_t stride = 1 + total / std::max<std::size_t>(most, 1);
  std::vector<GroupSample> samples;
  for (std::size_t s = 0; s < group.scans.size(); ++s) {
    const auto& surfels = group.scans[s]->map.surfels();
    const Rigid3& pose = group.group_from_scan[s];
    for (std::uint32_t i = 0; i < surfels.size(); i += static_cast<std::uint32_t>(stride)) {
      samples.push_back({pose * surfels[i].mean, pose.rotation * surfels[i].normal, 1.0, s, i});
    }
  }
  return samples;
}

class MapRefiner {
 public:
  MapRefiner(const MapModel& map, const ScanGroup& group, const MapRefinementOptions& options)
      : map_(map),
        group_(group),
        options_(options),
        samples_(Surfels(group, options.most_surfels)) {}

  MapRefinement Run(Sim3 pose) const;

 private:
  std::vector<MapResidual> Associate(const Sim3& pose, double gate) const;
  Vector7d Step(const Sim3& pose, const std::vector<MapResidual>& residuals, double gate,
                double floor_variance) const;
  Matrix7d Covariance(const Sim3& pose, const std::vector<MapResidual>& residuals) const;
  double ScaleInformation() const {
    return options_.sigma_scale > 0.0 ? 1.0 / (options_.sigma_scale * options_.sigma_scale) : 1e12;
  }

  const MapModel& map_;
  const ScanGroup& group_;
  const MapRefinementOptions& options_;
  std::vector<GroupSample> samples_;
};

Vector7d Jacobian(const Sim3& pose, const MapResidual& r) {
  const Eigen::Vector3d arm = r.place - pose.translation;
  Vector7d jacobian;
  jacobian << r.normal, arm.cross(r.normal), r.normal.dot(arm);
  return jacobian;
}

std::vector<MapResidual> MapRefiner::Associate(const Sim3& pose, double gate) const {
  std::vector<MapResidual> residuals;
  // A wide gate goes with a rotation that is off, too.
  const double least_cosine = gate > 0.3 ? 0.9 : 0.94;
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  for (const GroupSample& sample : samples_) {
    const Eigen::Vector3d place = pose.scale * (rotation * sample.mean) + pose.translation;
    const int found = map_.surfaces().Find(place, rotation * sample.normal, gate, least_cosine);
    if (found < 0) continue;
    const Surfel& surface = map_.surfaces().surfels()[found];
    const double own = group_.scans[sample.scan]->map.surfels()[sample.surfel].offset_variance;
    residuals.push_back({place, surface.normal, surface.normal.dot(place - surface.mean),
                         surface.HeightVariance(place) + own, sample.scan, found});
  }
  return residuals;
}

Vector7d MapRefiner::Step(const Sim3& pose, const std::vector<MapResidual>& residuals, double gate,
                          double floor_variance) const {
  Matrix7d information = Matrix7d::Zero();
  Vector7d gradient = Vector7d::Zero();
  for (const MapResidual& r : residuals) {
    const double variance = r.variance + floor_variance;
    const double width = std::max(gate * gate / 9.0, 9.0 * variance);
    const double robust = std::pow(width / (width + r.height * r.height), 2);
    const Vector7d jacobian = Jacobian(pose, r);
    information.noalias() += robust / variance * jacobian * jacobian.transpose();
    gradient.noalias() += robust / variance * r.height * jacobian;
  }
  information(6, 6) += ScaleInformation();
  // A scale that is held stays where the start has it.
  if (options_.sigma_scale > 0.0) {
    gradient(6) += ScaleInformation() * std::log(pose.scale / options_.scale);
  }
  if (!(options_.sigma_scale > 0.0)) gradient(6) = 0.0;
  // A millionth of the mean information keeps open directions where they are.
  const double translation = information.diagonal().head<3>().mean();
  const double rotation = information.diagonal().segment<3>(3).mean();
  information.diagonal().head<3>().array() += 1e-6 * translation + 1e-9;
  information.diagonal().segment<3>(3).array() += 1e-6 * rotation + 1e-9;
  return -information.ldlt().solve(gradient);
}

// Surfaces of one block err together: their information adds up to that of the block's mean.
Matrix7d MapRefiner::Covariance(const Sim3& pose, const std::vector<MapResidual>& residuals) const {
  const MapErrors errors = MeasureMapErrors(residuals);
  std::map<std::uint64_t, double> count;
  for (const auto& r : residuals) count[MapBlock(r.place, r.normal)] += 1.0;
  Matrix7d information = kMapRidge * Matrix7d::Identity();
  for (const auto& r : residuals) {
    const double in_block = count[MapBlock(r.place, r.normal)];
    const double variance = std::max({r.variance, errors.sigma * errors.sigma,
                                      in_block * errors.block_sigma * errors.block_sigma});
    const Vector7d jacobian = Jacobian(pose, r);
    information += jacobian * jacobian.transpose() / variance;
  }
  information(6, 6) += ScaleInformation();
  return information.ldlt().solve(Matrix7d::Identity());
}

MapRefinement MapRefiner::Run(Sim3 pose) const {
  MapRefinement result;
  double gate = options_.first_gate, floor = kLeastFloor * kLeastFloor;
  for (; result.iterations < options_.most_iterations; ++result.iterations) {
    const auto residuals = Associate(pose, gate);
    if (gate <= kMapCalibrationGate) {
      floor = std::max(kLeastFloor * kLeastFloor,
                       RobustVariance(residuals) - MedianVariance(residuals));
    }
    const Vector7d step = Step(pose, residuals, gate, floor);
    pose.rotation = (ExpSO3(step.segment<3>(3)) * pose.rotation).normalized();
    pose.translation += step.head<3>();
    pose.scale *= std::exp(std::clamp(step[6], -0.1, 0.1));
    const bool small =
        step.head<3>().norm() < options_.rest && step.segment<3>(3).norm() < 0.1 * options_.rest;
    if (small && gate <= options_.last_gate) {
      result.converged = true;
      break;
    }
    gate = std::max(options_.last_gate, MapRefinementOptions::kNarrowing * gate);
  }
  result.map_from_group = pose;
  if (options_.pose_only) return result;
  result.residuals = Associate(pose, options_.last_gate);
  result.floor = std::sqrt(floor);
  result.covariance = Covariance(pose, result.residuals);
  return result;
}

}  // namespace

std::uint64_t MapBlock(const Eigen::Vector3d& place, const Eigen::Vector3d& normal) {
  const Eigen::Vector3i cell = (place / MapErrors::kBlock).array().floor().cast<int>();
  constexpr std::int64_t kBias = 1 << 18;
  std::uint64_t key = static_cast<std::uint64_t>(CubeSide(normal));
  for (int k = 0; k < 3; ++k) key = (key << 19) | static_cast<std::uint64_t>(cell[k] + kBias);
  return key;
}

MapErrors MeasureMapErrors(const std::vector<MapResidual>& residuals) {
  constexpr std::size_t kLeastResiduals = 30, kLeastBlocks = 8;
  constexpr double kLeastInBlock = 4.0;
  MapErrors errors;
  if (residuals.size() < kLeastResiduals) return errors;
  errors.measured = true;
  errors.sigma = std::max(kLeastFloor, std::sqrt(RobustVariance(residuals)));
  std::map<std::uint64_t, std::pair<double, double>> blocks;  // count, sum
  for (const auto& r : residuals) {
    // One outlier in a block is not the block's error.
    if (std::abs(r.height) > 3.0 * errors.sigma) continue;
    auto& [count, sum] = blocks[MapBlock(r.place, r.normal)];
    count += 1.0;
    sum += r.height;
  }
  std::vector<double> squares;
  for (const auto& [key, block] : blocks) {
    if (block.first >= kLeastInBlock) squares.push_back(std::pow(block.second / block.first, 2));
  }
  errors.block_sigma = std::min(0.5 * errors.sigma, 0.02);
  if (squares.size() < kLeastBlocks) return errors;
  errors.block_sigma = std::max(0.3 * kLeastFloor, std::sqrt(Median(squares) / 0.455));
  return errors;
}

MapRefinement RefineInMap(const MapModel& map, const ScanGroup& group, const Sim3& map_from_group,
                          const MapRefinementOptions& options) {
  return MapRefiner(map, group, options).Run(map_from_group);
}

}  // namespace planegraph
