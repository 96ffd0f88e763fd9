#include "segmentation/greedy_projection_area.h"

#include "planegraph/base/error.h"

#ifdef PLANEGRAPH_WITH_PCL

#include <pcl/console/print.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/gp3.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <pcl/surface/impl/gp3.hpp>
#include <set>

namespace planegraph {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointNormal>;

// Edges of triangles are at most this long, metres; thinning to a tenth of it keeps the
// neighbourhoods that the triangulation looks at small.
constexpr double kLongestEdge = 0.5, kSpacing = 0.05;

// The first point of each cell. PCL drops points that coincide, and warns about them.
PclCloud::Ptr MakeCloud(const std::vector<Eigen::Vector2d>& points) {
  PclCloud::Ptr cloud(new PclCloud);
  std::set<std::pair<long, long>> taken;
  for (const auto& p : points) {
    const std::pair<long, long> cell(std::lround(p.x() / kSpacing), std::lround(p.y() / kSpacing));
    if (!taken.insert(cell).second) continue;
    pcl::PointNormal point;
    point.x = static_cast<float>(p.x());
    point.y = static_cast<float>(p.y());
    point.z = 0.0F;
    point.normal_x = point.normal_y = 0.0F;
    point.normal_z = 1.0F;
    cloud->push_back(point);
  }
  return cloud;
}

double TriangleArea(const PclCloud& cloud, const pcl::Vertices& triangle) {
  const auto at = [&](int k) { return cloud[triangle.vertices[k]].getVector3fMap(); };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
}

}  // namespace

double GreedyProjectionArea(const std::vector<Eigen::Vector2d>& points) {
  // Remarks on its neighbourhoods would go to the console.
  static const bool kQuiet = [] {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    return true;
  }();
  static_cast<void>(kQuiet);
  const PclCloud::Ptr cloud = MakeCloud(points);
  if (cloud->size() < 3) return 0.0;
  pcl::GreedyProjectionTriangulation<pcl::PointNormal> triangulation;
  triangulation.setSearchRadius(kLongestEdge);
  triangulation.setMu(3.0);
  triangulation.setMaximumNearestNeighbors(100);
  triangulation.setMaximumSurfaceAngle(std::numbers::pi / 4);
  triangulation.setMinimumAngle(std::numbers::pi / 18);
  triangulation.setMaximumAngle(2 * std::numbers::pi / 3);
  triangulation.setNormalConsistency(true);
  triangulation.setInputCloud(cloud);
  triangulation.setSearchMethod(
      pcl::search::KdTree<pcl::PointNormal>::Ptr(new pcl::search::KdTree<pcl::PointNormal>));
  std::vector<pcl::Vertices> triangles;
  triangulation.reconstruct(triangles);
  double area = 0.0;
  for (const auto& triangle : triangles) area += TriangleArea(*cloud, triangle);
  return area;
}

}  // namespace planegraph

#else

namespace planegraph {

double GreedyProjectionArea(const std::vector<Eigen::Vector2d>&) {
  throw UsageError(
      "greedy_projection_area: this build has no PCL (configure with -DPLANEGRAPH_WITH_PCL=ON)");
}

}  // namespace planegraph

#endif
