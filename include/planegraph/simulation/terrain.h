#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/simulation/labelled_mesh.h"

namespace planegraph {

/// A height profile: linear between its knots, constant beyond them.
struct Profile {
  std::vector<double> knots;    ///< increasing, metres
  std::vector<double> heights;  ///< one per knot, metres

  double Height(double at) const;
};

/// Ground of the height x.Height(x) + y.Height(y). Between the knots of both it is exactly planar,
/// so that it consists of few planes and is continuous.
struct Terrain {
  Profile x, y;

  double Height(const Eigen::Vector2d& position) const;
  /// The highest ground in the rectangle between two corners.
  double MaxHeight(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;
};

/// One plane per cell between the knots.
void AddTerrain(MeshBuilder* builder, const Terrain& terrain);

}  // namespace planegraph
