#pragma once

#include <Eigen/Core>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// Count, mean and centred scatter S = sum (p - mean)(p - mean)^T of a set of points. Two sets
/// merge in O(1), and S does not cancel at large coordinates (Welford; Chan et al. 1979).
struct Moments {
  double count = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();

  void Add(const Eigen::Vector3d& point) {
    count += 1.0;
    const Eigen::Vector3d delta = point - mean;
    mean += delta / count;
    scatter.noalias() += ((count - 1.0) / count) * delta * delta.transpose();
  }
  void Merge(const Moments& other) {
    if (other.count == 0.0) return;
    const double total = count + other.count;
    const Eigen::Vector3d delta = other.mean - mean;
    scatter += other.scatter + (count * other.count / total) * delta * delta.transpose();
    mean += (other.count / total) * delta;
    count = total;
  }
};

/// The moments of the same points seen from the target's frame.
inline Moments Transform(const Rigid3& target_from_source, const Moments& moments) {
  const Eigen::Matrix3d rotation = target_from_source.rotation.toRotationMatrix();
  return {moments.count, target_from_source * moments.mean,
          rotation * moments.scatter * rotation.transpose()};
}

/// Likewise under a similarity.
inline Moments Transform(const Sim3& target_from_source, const Moments& moments) {
  const Eigen::Matrix3d rotation =
      target_from_source.scale * target_from_source.rotation.toRotationMatrix();
  return {moments.count, target_from_source * moments.mean,
          rotation * moments.scatter * rotation.transpose()};
}

/// Eigenvalues of a symmetric matrix in increasing order with their unit eigenvectors as columns,
/// right-handed. For scatter matrices column 0 is the plane's normal up to its sign.
struct PrincipalAxes {
  Eigen::Vector3d values = Eigen::Vector3d::Zero();
  Eigen::Matrix3d vectors = Eigen::Matrix3d::Identity();
};
PrincipalAxes ComputePrincipalAxes(const Eigen::Matrix3d& symmetric);

}  // namespace planegraph
