#pragma once

#include <random>
#include <vector>

#include "planegraph/graph/graph.h"

namespace planegraph {

/// Random states and measurements for FactorType::sample: rotations of any angle, near the identity
/// and near pi, lengths from 1e-3 to 1e3, planes through the origin.
class FactorSampler {
 public:
  explicit FactorSampler(std::mt19937_64* rng) : rng_(*rng) { scale_ = LogUniform(1e-3, 1e3); }

  double Uniform(double low, double high);
  double LogUniform(double low, double high);
  Eigen::Vector3d UnitVector();
  /// Uniform direction, length up to the sample's scale.
  Eigen::Vector3d Point();
  Eigen::Quaterniond Rotation();
  Rigid3 Pose() { return {Rotation(), Point()}; }
  /// A pose within a tenth of a radian (and of the scale) of another.
  Rigid3 Near(const Rigid3& pose);
  Sim3 Map() { return {LogUniform(1e-3, 1e3), Rotation(), Point()}; }
  PlaneObservation Observation(int pose);
  /// A landmark without observations; one in four passes through its anchor, one in four is
  /// anchored at the origin.
  PlaneLandmark Landmark();
  /// Positive semi-definite, of full rank or not.
  Matrix6d Information();

  static std::vector<double> Block(const Rigid3& pose);
  static std::vector<double> Block(const PlaneLandmark& plane);
  static std::vector<double> Block(const Sim3& map);

 private:
  std::mt19937_64& rng_;
  double scale_;
};

}  // namespace planegraph
