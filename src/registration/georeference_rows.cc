#include "registration/georeference_rows.h"

#include <cmath>

#include "planegraph/geometry/rotation.h"

namespace planegraph {

SimilarityRows::SimilarityRows(const std::vector<PositionPair>& pairs, const Sim3& world_from_map)
    : world_from_map_(world_from_map), centroid_(Eigen::Vector3d::Zero()) {
  for (const auto& pair : pairs) centroid_ += pair.in_map;
  centroid_ /= static_cast<double>(pairs.size());
  centroid_in_world_ = world_from_map * centroid_;
}

SimilarityRows::Row SimilarityRows::Of(const PositionPair& pair) const {
  const Eigen::Vector3d lever =
      world_from_map_.scale * (world_from_map_.rotation * (pair.in_map - centroid_));
  Row row;
  row.residual = lever + (centroid_in_world_ - pair.in_world);
  row.jacobian << Eigen::Matrix3d::Identity(), -Hat(lever), lever;
  return row;
}

Sim3 SimilarityRows::Moved(const Eigen::Matrix<double, 7, 1>& step) const {
  Sim3 moved;
  moved.scale = world_from_map_.scale * std::exp(step[6]);
  moved.rotation = (ExpSO3(step.segment<3>(3)) * world_from_map_.rotation).normalized();
  moved.translation =
      centroid_in_world_ + step.head<3>() - moved.scale * (moved.rotation * centroid_);
  return moved;
}

Matrix7d SimilarityRows::AtMapOrigin(const Matrix7d& covariance) const {
  const Eigen::Vector3d lever = world_from_map_.scale * (world_from_map_.rotation * centroid_);
  Matrix7d jacobian = Matrix7d::Identity();
  jacobian.block<3, 3>(0, 3) = Hat(lever);
  jacobian.block<3, 1>(0, 6) = -lever;
  return jacobian * covariance * jacobian.transpose();
}

void Damp(Matrix7d* normal) {
  constexpr double kShare = 1e-13;
  auto diagonal = normal->diagonal();
  diagonal.head<3>().array() += kShare * diagonal.head<3>().sum();
  diagonal.segment<3>(3).array() += kShare * diagonal.segment<3>(3).sum();
  diagonal[6] += kShare * diagonal[6] + 1e-300;
}

}  // namespace planegraph
