#include "pipeline/model_frame.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "planegraph/base/median.h"
#include "planegraph/cloud/kd_tree.h"
#include "planegraph/io/camera_io.h"

namespace planegraph {
namespace {

constexpr std::size_t kMostPatches = 2000;
// The points of a model lie all over what its cameras saw, and the cloud may be a part of that: in
// one frame nearly all of it lies near them, in two hardly anything.
constexpr double kNear = 0.2;  // of the spread of the larger of both
// N points over a disc of radius 1.5 spreads are sqrt(7 / N) spreads apart: 0.12 here.
constexpr std::size_t kLeastPoints = 500;
constexpr double kLeastShare = 0.5;

std::vector<Eigen::Vector3f> ModelPoints(const std::string& cameras, const Sim3& metric_from_map) {
  std::vector<Eigen::Vector3f> points;
  for (const Eigen::Vector3d& point : ReadCameras(cameras).points) {
    const Eigen::Vector3f moved = (metric_from_map * point).cast<float>();
    if (moved.allFinite()) points.push_back(moved);
  }
  return points;
}

std::vector<Eigen::Vector3f> SampleOf(const PlaneSet& planes) {
  std::vector<Eigen::Vector3f> sample;
  const std::size_t step = 1 + planes.patches.size() / kMostPatches;
  for (std::size_t i = 0; i < planes.patches.size(); i += step) {
    sample.emplace_back(planes.patches[i].moments.mean.cast<float>());
  }
  return sample;
}

// The median distance from the point of median coordinates.
double SpreadOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3f middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(points.size());
    for (const Eigen::Vector3f& point : points) values.push_back(point[axis]);
    middle[axis] = static_cast<float>(Median(std::move(values)));
  }
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Eigen::Vector3f& point : points) distances.push_back((point - middle).norm());
  return Median(std::move(distances));
}

// The share of `points` that have one of `others` nearby.
double ShareNear(const std::vector<Eigen::Vector3f>& points,
                 const std::vector<Eigen::Vector3f>& others, double distance) {
  const KdTree tree(others);
  std::vector<KdTree::Neighbour> nearest;
  std::size_t near = 0;
  for (const Eigen::Vector3f& point : points) {
    tree.Nearest(point, 1, &nearest);
    near += std::sqrt(nearest.front().squared_distance) <= distance ? 1 : 0;
  }
  return static_cast<double>(near) / static_cast<double>(points.size());
}

}  // namespace

std::optional<std::string> ModelFrameWarning(const DroneMapSite& site, const MapRecord& map) {
  if (site.cameras.empty()) return {};
  const auto model = ModelPoints(site.cameras, map.metric_from_map);
  const auto cloud = SampleOf(map.planes);
  if (model.size() < kLeastPoints || cloud.empty()) return {};
  const double share = ShareNear(cloud, model, kNear * std::max(SpreadOf(cloud), SpreadOf(model)));
  if (share >= kLeastShare) return {};
  return site.name + ": only " + std::to_string(std::lround(100.0 * share)) +
         " % of its cloud lies near the points of its cameras' model: are both in one frame? The "
         "cloud has to be as the model has it, not moved to UTM or scaled";
}

}  // namespace planegraph
