#include "simulation/layout.h"

#include <algorithm>
#include <limits>

namespace planegraph {

double DistanceToPath(const std::vector<Eigen::Vector2d>& path, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Eigen::Vector2d along = path[i + 1] - path[i];
    const double t = std::clamp((point - path[i]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (path[i] + t * along - point).norm());
  }
  return nearest;
}

bool Layout::IsFree(const Eigen::Vector2d& center, double radius) const {
  if (DistanceToPath(path_, center) < radius + clearance_) return false;
  return std::none_of(discs_.begin(), discs_.end(), [&](const Disc& disc) {
    return (disc.center - center).norm() < disc.radius + radius;
  });
}

void Layout::Occupy(const Eigen::Vector2d& center, double radius) {
  discs_.push_back({center, radius});
}

std::optional<Eigen::Vector2d> Layout::Place(const Eigen::Vector2d& low,
                                             const Eigen::Vector2d& high, double radius,
                                             Random* random) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    const double x = random->Uniform(low.x(), high.x());
    const Eigen::Vector2d center(x, random->Uniform(low.y(), high.y()));
    if (!IsFree(center, radius)) continue;
    Occupy(center, radius);
    return center;
  }
  return std::nullopt;
}

}  // namespace planegraph
