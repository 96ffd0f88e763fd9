#include "planegraph/cloud/normals.h"

#include <algorithm>

#include "planegraph/base/parallel.h"
#include "planegraph/cloud/kd_tree.h"
#include "planegraph/geometry/moments.h"

namespace planegraph {
namespace {

LocalShape ShapeOf(const Cloud& cloud, const std::vector<KdTree::Neighbour>& near,
                   const Eigen::Vector3f& towards) {
  Moments moments;
  for (const auto& n : near) moments.Add(cloud.points[n.index].cast<double>());
  const PrincipalAxes axes = ComputePrincipalAxes(moments.scatter);
  LocalShape shape;
  shape.normal = axes.vectors.col(0).cast<float>();
  if (shape.normal.dot(towards) < 0) shape.normal = -shape.normal;
  shape.variances = (axes.values / moments.count).cwiseMax(0.0).cast<float>();
  return shape;
}

}  // namespace

std::vector<LocalShape> ComputeLocalShapes(const Cloud& cloud, std::size_t k, int threads) {
  std::vector<LocalShape> shapes(cloud.size());
  if (cloud.size() < 3) return shapes;
  const KdTree tree(cloud.points);
  const Eigen::Vector3f viewpoint = (cloud.viewpoint - cloud.offset).cast<float>();
  constexpr std::size_t kBlock = 1024;
  ParallelFor((cloud.size() + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
    std::vector<KdTree::Neighbour> near;
    const std::size_t end = std::min(cloud.size(), (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      tree.Nearest(cloud.points[i], std::max<std::size_t>(k, 3), &near);
      shapes[i] = ShapeOf(cloud, near, viewpoint - cloud.points[i]);
    }
  });
  return shapes;
}

Cloud WithNormals(Cloud cloud, std::size_t k, int threads) {
  const auto shapes = ComputeLocalShapes(cloud, k, threads);
  cloud.normals.clear();
  for (const LocalShape& shape : shapes) cloud.normals.push_back(shape.normal);
  return cloud;
}

}  // namespace planegraph
