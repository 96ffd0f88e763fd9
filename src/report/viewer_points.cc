#include "report/viewer_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "planegraph/geometry/moments.h"

namespace planegraph {
namespace {

constexpr std::uint16_t kNoPlane = 65535;
constexpr double kSteps = 65535.0;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A plane in the world's axes.
struct WorldPlane {
  Eigen::Vector3d normal;
  double distance;
};

// ---- residuals ----

// Planes of the drone's points, by their number, where there are enough points to tell.
std::map<std::int32_t, WorldPlane> FitDronePlanes(const MapSample& sample) {
  constexpr double kLeastPoints = 12;
  std::map<std::int32_t, Moments> moments;
  for (const MapPlyPoint& p : sample.points) {
    if (p.scan < 0 && p.plane >= 0) moments[p.plane].Add(p.position.cast<double>());
  }
  std::map<std::int32_t, WorldPlane> planes;
  for (const auto& [number, sums] : moments) {
    if (sums.count < kLeastPoints) continue;
    const Eigen::Vector3d normal = ComputePrincipalAxes(sums.scatter).vectors.col(0);
    planes[number] = {normal, normal.dot(sums.mean + sample.offset)};
  }
  return planes;
}

class Residuals {
 public:
  Residuals(const ReportData& data, const ViewerInput& input)
      : offset_(input.sample.offset), drone_(FitDronePlanes(input.sample)) {
    scans_.resize(data.scans.size());
    for (std::size_t i = 0; i < data.scans.size() && i < input.planes.size(); ++i) {
      const auto pose = PoseOf(data.scans[i]);
      if (!pose) continue;
      for (const ViewerPlane& plane : input.planes[i]) scans_[i].push_back(Moved(plane, *pose));
    }
  }

  // Metres; NaN where the point has no plane that is known.
  double Of(const MapPlyPoint& point) const {
    const WorldPlane* plane = Find(point);
    if (plane == nullptr) return kNone;
    return plane->normal.dot(point.position.cast<double>() + offset_) - plane->distance;
  }

 private:
  static WorldPlane Moved(const ViewerPlane& plane, const Rigid3& pose) {
    const Eigen::Vector3d normal = pose.rotation * plane.normal;
    return {normal, plane.hull.empty() ? kNone : plane.distance + normal.dot(pose.translation)};
  }
  const WorldPlane* Find(const MapPlyPoint& point) const {
    if (point.plane < 0) return nullptr;
    if (point.scan < 0) {
      const auto found = drone_.find(point.plane);
      return found == drone_.end() ? nullptr : &found->second;
    }
    const auto scan = static_cast<std::size_t>(point.scan);
    const auto plane = static_cast<std::size_t>(point.plane);
    if (scan >= scans_.size() || plane >= scans_[scan].size()) return nullptr;
    return &scans_[scan][plane];
  }

  Eigen::Vector3d offset_;
  std::map<std::int32_t, WorldPlane> drone_;
  std::vector<std::vector<WorldPlane>> scans_;
};

// So that all but the largest fiftieth of the residuals fit into a byte.
double ResidualStep(std::vector<double> residuals) {
  constexpr double kLeast = 1e-5, kMost = 0.01, kShare = 0.98;
  std::erase_if(residuals, [](double r) { return !std::isfinite(r); });
  if (residuals.empty()) return 0.001;
  for (double& r : residuals) r = std::abs(r);
  const auto at = residuals.begin() +
                  static_cast<std::ptrdiff_t>(kShare * static_cast<double>(residuals.size() - 1));
  std::nth_element(residuals.begin(), at, residuals.end());
  return std::clamp(*at / 127.0, kLeast, kMost);
}

char ResidualByte(double residual, double step) {
  if (!std::isfinite(residual)) return -128;
  return static_cast<char>(std::lround(std::clamp(residual / step, -127.0, 127.0)));
}

// ---- columns ----

// Neighbours in the file are neighbours in space: their differences compress well.
void AppendDifferences(const std::vector<std::uint16_t>& values, std::string* columns) {
  std::string high;
  std::uint16_t before = 0;
  for (const std::uint16_t value : values) {
    const auto difference = static_cast<std::uint16_t>(value - before);
    *columns += static_cast<char>(difference & 255);
    high += static_cast<char>(difference >> 8);
    before = value;
  }
  *columns += high;
}

void AddToRuns(std::int32_t scan, std::vector<ViewerRun>* runs) {
  if (runs->empty() || runs->back().scan != scan) runs->push_back({scan, 0});
  ++runs->back().count;
}

std::uint16_t PlaneNumber(std::int32_t plane) {
  return plane < 0 || plane >= kNoPlane ? kNoPlane : static_cast<std::uint16_t>(plane);
}

}  // namespace

ViewerBox ChooseViewerBox(const MapSample& sample, const std::vector<Eigen::Vector3d>& positions) {
  constexpr double kStray = 0.001, kMargin = 0.15;
  constexpr std::size_t kLeastForQuantiles = 1000;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (int axis = 0; axis < 3 && !sample.points.empty(); ++axis) {
    std::vector<float> values;
    for (const MapPlyPoint& p : sample.points) values.push_back(p.position[axis]);
    const double share = values.size() < kLeastForQuantiles ? 0.0 : kStray;
    const auto at = [&](double quantile) {
      const auto k = static_cast<std::ptrdiff_t>(quantile * static_cast<double>(values.size() - 1));
      std::nth_element(values.begin(), values.begin() + k, values.end());
      return static_cast<double>(values[static_cast<std::size_t>(k)]) + sample.offset[axis];
    };
    low[axis] = at(share);
    high[axis] = at(1.0 - share);
    const double margin = kMargin * (high[axis] - low[axis]);
    low[axis] -= margin;
    high[axis] += margin;
  }
  for (const Eigen::Vector3d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (!(low.array() <= high.array()).all()) return {};
  return {low, (high - low).cwiseMax(0.01)};
}

ViewerPoints PackViewerPoints(const ReportData& data, const ViewerInput& input,
                              const ViewerBox& box) {
  ViewerPoints packed;
  const Residuals residuals(data, input);
  std::vector<std::uint16_t> place[3], planes;
  std::vector<double> distances;
  std::string colours[3];
  for (const MapPlyPoint& p : input.sample.points) {
    const Eigen::Vector3d x_in_world = p.position.cast<double>() + input.sample.offset;
    const Eigen::Array3d at = (x_in_world - box.low).cwiseQuotient(box.extent).array();
    if ((at < 0.0).any() || (at > 1.0).any()) continue;
    for (int axis = 0; axis < 3; ++axis) {
      place[axis].push_back(static_cast<std::uint16_t>(std::lround(at[axis] * kSteps)));
      colours[axis] += static_cast<char>(p.rgb[static_cast<std::size_t>(axis)]);
    }
    planes.push_back(PlaneNumber(p.plane));
    distances.push_back(residuals.Of(p));
    AddToRuns(p.source == PointSource::kVision ? -1 : std::max(p.scan, 0), &packed.runs);
  }
  packed.count = planes.size();
  packed.residual_step = ResidualStep(distances);
  for (const auto& axis : place) AppendDifferences(axis, &packed.columns);
  AppendDifferences(planes, &packed.columns);
  for (const std::string& channel : colours) packed.columns += channel;
  for (const double r : distances) packed.columns += ResidualByte(r, packed.residual_step);
  return packed;
}

}  // namespace planegraph
