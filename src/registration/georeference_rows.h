#pragma once

#include <vector>

#include "registration/georeference_pairs.h"

namespace planegraph {

/// The residuals world_from_map * x_in_map - x_in_world, linear about a similarity. Parameters:
/// shift of the centroid (m), left rotation vector (rad), log of the scale. About the centroid the
/// three hardly depend on each other, wherever the map's own origin is.
class SimilarityRows {
 public:
  SimilarityRows(const std::vector<PositionPair>& pairs, const Sim3& world_from_map);

  struct Row {
    Eigen::Vector3d residual;
    Eigen::Matrix<double, 3, 7> jacobian;
  };
  Row Of(const PositionPair& pair) const;
  /// The similarity after a step of the parameters.
  Sim3 Moved(const Eigen::Matrix<double, 7, 1>& step) const;
  /// The covariance of the parameters as that of the translation, rotation and log of the scale.
  Matrix7d AtMapOrigin(const Matrix7d& covariance) const;

 private:
  Sim3 world_from_map_;
  Eigen::Vector3d centroid_;           // in the map
  Eigen::Vector3d centroid_in_world_;  // as the similarity maps it
};

/// Adds a trace of each block to the diagonal, so that parameters which the positions leave open
/// stay where they are.
void Damp(Matrix7d* normal);

}  // namespace planegraph
