#include "planegraph/cloud/cloud.h"

namespace planegraph {
namespace {

template <typename T>
std::vector<T> Pick(const std::vector<T>& values, const std::vector<std::uint32_t>& indices) {
  std::vector<T> picked;
  if (values.empty()) return picked;
  picked.reserve(indices.size());
  for (const std::uint32_t i : indices) picked.push_back(values[i]);
  return picked;
}

}  // namespace

Cloud Select(const Cloud& cloud, const std::vector<std::uint32_t>& indices) {
  Cloud picked;
  picked.offset = cloud.offset;
  picked.viewpoint = cloud.viewpoint;
  picked.points = Pick(cloud.points, indices);
  picked.normals = Pick(cloud.normals, indices);
  picked.colors = Pick(cloud.colors, indices);
  picked.intensities = Pick(cloud.intensities, indices);
  return picked;
}

}  // namespace planegraph
