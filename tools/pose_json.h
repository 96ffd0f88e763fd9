#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/sim3.h"

namespace planegraph::tools {

/// `{translation, rotation}` with the quaternion as x y z w.
inline nlohmann::json PoseToJson(const Rigid3& pose) {
  const auto& t = pose.translation;
  const auto& q = pose.rotation;
  return {{"translation", {t.x(), t.y(), t.z()}}, {"rotation", {q.x(), q.y(), q.z(), q.w()}}};
}

/// The same with `scale`.
inline nlohmann::json SimilarityToJson(const Sim3& similarity) {
  nlohmann::json json = PoseToJson({similarity.rotation, similarity.translation});
  json["scale"] = similarity.scale;
  return json;
}

/// Null for what is larger than `most`: a value that stands for infinite.
inline nlohmann::json FiniteOrNull(double value, double most) {
  return std::abs(value) <= most ? nlohmann::json(value) : nlohmann::json();
}

/// Row by row, entries above `most` as null.
template <typename Matrix>
nlohmann::json CovarianceToJson(const Matrix& covariance, double most) {
  nlohmann::json out = nlohmann::json::array();
  for (Eigen::Index row = 0; row < covariance.rows(); ++row) {
    for (Eigen::Index column = 0; column < covariance.cols(); ++column) {
      out.push_back(FiniteOrNull(covariance(row, column), most));
    }
  }
  return out;
}

}  // namespace planegraph::tools
