#include "planegraph/simulation/terrain.h"

#include <algorithm>

namespace planegraph {

double Profile::Height(double at) const {
  if (at <= knots.front()) return heights.front();
  if (at >= knots.back()) return heights.back();
  const auto upper = std::upper_bound(knots.begin(), knots.end(), at) - knots.begin();
  const double share = (at - knots[upper - 1]) / (knots[upper] - knots[upper - 1]);
  return heights[upper - 1] + share * (heights[upper] - heights[upper - 1]);
}

double Terrain::Height(const Eigen::Vector2d& position) const {
  return x.Height(position.x()) + y.Height(position.y());
}

double Terrain::MaxHeight(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const {
  const auto most = [](const Profile& profile, double from, double to) {
    double height = std::max(profile.Height(from), profile.Height(to));
    for (std::size_t i = 0; i < profile.knots.size(); ++i) {
      if (profile.knots[i] > from && profile.knots[i] < to) {
        height = std::max(height, profile.heights[i]);
      }
    }
    return height;
  };
  return most(x, low.x(), high.x()) + most(y, low.y(), high.y());
}

void AddTerrain(MeshBuilder* builder, const Terrain& terrain) {
  const auto corner = [&](std::size_t i, std::size_t j) {
    return Eigen::Vector3d(terrain.x.knots[i], terrain.y.knots[j],
                           terrain.x.heights[i] + terrain.y.heights[j]);
  };
  for (std::size_t i = 0; i + 1 < terrain.x.knots.size(); ++i) {
    for (std::size_t j = 0; j + 1 < terrain.y.knots.size(); ++j) {
      builder->AddFace({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  }
}

}  // namespace planegraph
