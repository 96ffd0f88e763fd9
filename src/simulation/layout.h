#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planegraph/simulation/random.h"

namespace planegraph {

/// Keeps things apart on the ground plan: from each other and from the robot's path. All as discs,
/// metres.
class Layout {
 public:
  Layout(std::vector<Eigen::Vector2d> path, double clearance)
      : path_(std::move(path)), clearance_(clearance) {}

  bool IsFree(const Eigen::Vector2d& center, double radius) const;
  void Occupy(const Eigen::Vector2d& center, double radius);
  /// A free place in the rectangle between two corners, which is then occupied; none where many
  /// tries did not find one.
  std::optional<Eigen::Vector2d> Place(const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                                       double radius, Random* random);

 private:
  struct Disc {
    Eigen::Vector2d center;
    double radius;
  };
  std::vector<Eigen::Vector2d> path_;
  std::vector<Disc> discs_;
  double clearance_;
};

/// Distance of a point from a polyline.
double DistanceToPath(const std::vector<Eigen::Vector2d>& path, const Eigen::Vector2d& point);

}  // namespace planegraph
