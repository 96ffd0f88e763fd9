#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

namespace planegraph {

/// A kd-tree over points that it refers to (not copies): the vector must outlive the tree and stay
/// unchanged. Distances are metres, squared where said. Backed by nanoflann.
class KdTree {
 public:
  explicit KdTree(const std::vector<Eigen::Vector3f>& points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;

  struct Neighbour {
    std::uint32_t index;
    float squared_distance;
  };
  /// The k nearest points (fewer where the cloud is smaller), nearest first; `query` itself
  /// included where it is in the cloud.
  void Nearest(const Eigen::Vector3f& query, std::size_t k, std::vector<Neighbour>* out) const;
  /// All points within `radius`, in no particular order.
  void Within(const Eigen::Vector3f& query, float radius, std::vector<Neighbour>* out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planegraph
