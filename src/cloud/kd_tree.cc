#include "planegraph/cloud/kd_tree.h"

#include <algorithm>
#include <nanoflann.hpp>
#include <utility>

namespace planegraph {
namespace {

constexpr std::size_t kLeafPoints = 16;

struct PointsAdaptor {
  const std::vector<Eigen::Vector3f>& points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[index][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointsAdaptor>,
                                                 PointsAdaptor, 3, std::uint32_t>;

}  // namespace

struct KdTree::Impl {
  explicit Impl(const std::vector<Eigen::Vector3f>& points)
      : adaptor{points}, tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafPoints)) {}

  PointsAdaptor adaptor;
  Tree tree;
};

KdTree::KdTree(const std::vector<Eigen::Vector3f>& points)
    : impl_(std::make_unique<Impl>(points)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

void KdTree::Nearest(const Eigen::Vector3f& query, std::size_t k,
                     std::vector<Neighbour>* out) const {
  k = std::min(k, impl_->adaptor.points.size());
  out->clear();
  if (k == 0) return;
  std::vector<std::uint32_t> indices(k);
  std::vector<float> distances(k);
  const std::size_t found =
      impl_->tree.knnSearch(query.data(), k, indices.data(), distances.data());
  for (std::size_t i = 0; i < found; ++i) out->push_back({indices[i], distances[i]});
}

void KdTree::Within(const Eigen::Vector3f& query, float radius, std::vector<Neighbour>* out) const {
  std::vector<std::pair<std::uint32_t, float>> found;
  nanoflann::SearchParams parameters;
  parameters.sorted = false;
  impl_->tree.radiusSearch(query.data(), radius * radius, found, parameters);
  out->clear();
  for (const auto& [index, squared] : found) out->push_back({index, squared});
}

}  // namespace planegraph
