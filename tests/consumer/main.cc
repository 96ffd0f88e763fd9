// Uses the installed headers and libraries: the corners of a triangle, moved, are aligned again.
#include <iostream>
#include <vector>

#include "planegraph/geometry/alignment.h"

int main() {
  const std::vector<Eigen::Vector3d> source = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}};
  std::vector<Eigen::Vector3d> target;
  for (const auto& point : source) target.push_back(point + Eigen::Vector3d(3, 4, 5));
  const auto alignment = planegraph::AlignPoints(source, target, false);
  const Eigen::Vector3d translation = alignment.target_from_source.translation;
  std::cout << "translation " << translation.transpose() << "\n";
  return (translation - Eigen::Vector3d(3, 4, 5)).norm() < 1e-12 ? 0 : 1;
}
