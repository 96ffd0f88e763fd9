#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/sim3.h"

namespace planegraph {

/// Null for what is not finite.
inline nlohmann::json Number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

template <typename Vector>
nlohmann::json Array(const Vector& v) {
  nlohmann::json array = nlohmann::json::array();
  for (int i = 0; i < v.size(); ++i) array.push_back(Number(v[i]));
  return array;
}

/// An array of its rows.
template <typename Matrix>
nlohmann::json MatrixJson(const Matrix& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < matrix.rows(); ++r) {
    rows.push_back(Array(Eigen::VectorXd(matrix.row(r).transpose())));
  }
  return rows;
}

inline nlohmann::json PoseJson(const Rigid3& pose) {
  return {{"translation", Array(pose.translation)}, {"rotation", Array(pose.rotation.coeffs())}};
}

inline nlohmann::json SimilarityJson(const Sim3& similarity) {
  nlohmann::json json = PoseJson({similarity.rotation, similarity.translation});
  json["scale"] = similarity.scale;
  return json;
}

}  // namespace planegraph
