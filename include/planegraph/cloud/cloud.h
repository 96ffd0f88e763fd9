#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace planegraph {

/// A point cloud in metres. The position of point i is offset + points[i]: large coordinates (UTM,
/// ECEF) never enter a float. The optional attributes are empty or as long as `points`.
struct Cloud {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::uint8_t, 3>> colors;
  std::vector<float> intensities;
  /// Where the sensor stood, in the same frame (not offset). Laser planes are turned towards it.
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();

  std::size_t size() const { return points.size(); }
  Eigen::Vector3d Position(std::size_t i) const { return offset + points[i].cast<double>(); }
};

/// The points (with all attributes) at `indices`, in that order.
Cloud Select(const Cloud& cloud, const std::vector<std::uint32_t>& indices);

}  // namespace planegraph
