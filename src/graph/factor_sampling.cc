#include "planegraph/graph/factor_sampling.h"

#include <cmath>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {

double FactorSampler::Uniform(double low, double high) {
  return low + (high - low) * (static_cast<double>(rng_() >> 11) * 0x1.0p-53);
}

double FactorSampler::LogUniform(double low, double high) {
  return std::exp(Uniform(std::log(low), std::log(high)));
}

Eigen::Vector3d FactorSampler::UnitVector() {
  const double z = Uniform(-1.0, 1.0), angle = Uniform(-EIGEN_PI, EIGEN_PI);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Eigen::Vector3d FactorSampler::Point() { return Uniform(0.0, scale_) * UnitVector(); }

Eigen::Quaterniond FactorSampler::Rotation() {
  const double kind = Uniform(0.0, 1.0);
  double angle = Uniform(0.0, EIGEN_PI - 0.01);
  if (kind < 0.25) angle = LogUniform(1e-10, 1e-3);
  if (kind > 0.75) angle = EIGEN_PI - LogUniform(1e-3, 1e-2);
  const Eigen::Quaterniond rotation = ExpSO3(angle * UnitVector());
  return Uniform(0.0, 1.0) < 0.5 ? rotation : Eigen::Quaterniond(-rotation.coeffs());
}

Rigid3 FactorSampler::Near(const Rigid3& pose) {
  return {(ExpSO3(Uniform(0.0, 0.1) * UnitVector()) * pose.rotation).normalized(),
          pose.translation + 0.1 * Point()};
}

PlaneObservation FactorSampler::Observation(int pose) {
  PlaneObservation seen;
  seen.pose = pose;
  seen.centroid = Point();
  seen.axes = Rotation().toRotationMatrix();
  seen.tilt_weight_1 = LogUniform(1.0, 1e4);
  seen.tilt_weight_2 = LogUniform(1.0, 1e4);
  seen.offset_weight = LogUniform(1.0, 1e4);
  return seen;
}

PlaneLandmark FactorSampler::Landmark() {
  PlaneLandmark plane;
  const double kind = Uniform(0.0, 1.0);
  plane.normal = UnitVector();
  if (kind > 0.25) plane.anchor = Point();
  if (kind < 0.75) plane.offset = Uniform(-scale_, scale_);
  return plane;
}

Matrix6d FactorSampler::Information() {
  Matrix6d root = Matrix6d::Zero();
  const int rank = Uniform(0.0, 1.0) < 0.5 ? 6 : 4;
  for (int row = 0; row < rank; ++row) {
    for (int column = 0; column < 6; ++column) root(row, column) = Uniform(-10.0, 10.0);
  }
  return root.transpose() * root;
}

std::vector<double> FactorSampler::Block(const Rigid3& pose) {
  std::vector<double> block(kPoseSize);
  PoseToBlock(pose, block.data());
  return block;
}

std::vector<double> FactorSampler::Block(const PlaneLandmark& plane) {
  return {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset};
}

std::vector<double> FactorSampler::Block(const Sim3& map) {
  std::vector<double> block(kMapSize);
  MapToBlock(map, block.data());
  return block;
}

}  // namespace planegraph
