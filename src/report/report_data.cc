#include "report/report_data.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "planegraph/base/angles.h"
#include "report/html.h"

namespace planegraph {
namespace {

constexpr double kFarthest = 1e8;  ///< metres: positions beyond are no positions on Earth

std::optional<Eigen::Vector3d> PositionOf(const Json& scan) {
  const auto position = VectorAt(scan, {"world_from_scan", "translation"});
  if (!position || position->cwiseAbs().maxCoeff() > kFarthest) return std::nullopt;
  return position;
}

std::size_t IndexOf(const std::string& robot, std::vector<std::string>* robots) {
  const auto found = std::find(robots->begin(), robots->end(), robot);
  if (found != robots->end()) return static_cast<std::size_t>(found - robots->begin());
  robots->push_back(robot);
  return robots->size() - 1;
}

// ROBOT/NNN.
void SplitId(ReportScan* scan) {
  const std::size_t slash = scan->id.rfind('/');
  if (slash == std::string::npos) {
    scan->number = scan->id;
    return;
  }
  scan->robot = scan->id.substr(0, slash);
  scan->number = scan->id.substr(slash + 1);
}

std::optional<int> ComponentOf(const Json& scan) {
  const auto number = NumberAt(scan, {"component"});
  if (!number || !(*number >= 0.0 && *number < 1e9)) return std::nullopt;
  return static_cast<int>(*number);
}

void FindApart(ReportData* data) {
  const int main = MainComponent(ComponentScans(*data));
  for (ReportScan& scan : data->scans) {
    scan.stands_apart = scan.component && *scan.component != main;
    data->is_whole &= !scan.stands_apart;
  }
}

std::string AxisText(const Eigen::Vector3d& axis) {
  return "(" + Fixed(axis.x(), 2) + ", " + Fixed(axis.y(), 2) + ", " + Fixed(axis.z(), 2) + ")";
}

}  // namespace

// Six rows of six, or 36 numbers in a row.
std::optional<Matrix6> CovarianceOf(const Json& owner) {
  const Json& list = ListAt(owner, {"covariance"});
  Json flat = Json::array();
  for (const Json& item : list) {
    if (item.is_array()) {
      flat.insert(flat.end(), item.begin(), item.end());
    } else {
      flat.push_back(item);
    }
  }
  const auto numbers = NumbersAt({{"covariance", flat}}, {"covariance"}, 36);
  if (!numbers) return std::nullopt;
  return Matrix6(Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(numbers->data()));
}

const ReportScan* ReportData::Find(const std::string& id) const {
  for (const ReportScan& scan : scans) {
    if (scan.id == id) return &scan;
  }
  return nullptr;
}

std::vector<Eigen::Vector3d> ReportData::Positions() const {
  std::vector<Eigen::Vector3d> positions;
  for (const ReportScan& scan : scans) {
    if (scan.position) positions.push_back(*scan.position);
  }
  return positions;
}

bool IsFixed(const ReportScan& scan) { return scan.covariance && scan.covariance->isZero(0.0); }

bool ApartPlacedByNothing(const ReportData& data) {
  return std::any_of(data.scans.begin(), data.scans.end(), [](const ReportScan& scan) {
    return scan.stands_apart && (!scan.covariance || IsFixed(scan));
  });
}

std::vector<ComponentScan> ComponentScans(const ReportData& data) {
  std::vector<ComponentScan> scans;
  for (const ReportScan& scan : data.scans) {
    if (scan.component) scans.push_back({scan.id, *scan.component});
  }
  return scans;
}

std::vector<std::string> AnchorsOf(const Json& scan) {
  std::vector<std::string> names;
  for (const Json& name : ListAt(scan, {"anchored_to"})) {
    if (name.is_string()) names.push_back(name.get<std::string>());
  }
  return names;
}

ReportData ReadReportData(const Json& json) {
  ReportData data;
  data.json = &json;
  for (const Json& entry : ListAt(json, {"scans"})) {
    ReportScan scan;
    scan.json = &entry;
    scan.id = TextAt(entry, {"id"});
    SplitId(&scan);
    scan.robot_index = IndexOf(scan.robot, &data.robots);
    scan.position = PositionOf(entry);
    scan.covariance = CovarianceOf(entry);
    scan.component = ComponentOf(entry);
    data.scans.push_back(std::move(scan));
  }
  FindApart(&data);
  for (const Json& entry : ListAt(json, {"maps"})) {
    ReportMap map{TextAt(entry, {"id"}), 0, &entry};
    for (const ReportScan& scan : data.scans) {
      const auto anchors = AnchorsOf(*scan.json);
      map.anchored += std::find(anchors.begin(), anchors.end(), map.id) != anchors.end() ? 1 : 0;
    }
    data.maps.push_back(std::move(map));
  }
  return data;
}

std::optional<Rigid3> PoseOf(const ReportScan& scan) {
  const auto q = NumbersAt(*scan.json, {"world_from_scan", "rotation"}, 4);
  if (!q || !scan.position) return std::nullopt;
  const Eigen::Quaterniond rotation((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
  if (!(std::abs(rotation.norm() - 1.0) < 1e-3)) return std::nullopt;
  return Rigid3{rotation.normalized(), *scan.position};
}

std::vector<OpenDirection> OpenDirections(const Json& owner) {
  std::vector<OpenDirection> list;
  for (const Json& entry : ListAt(owner, {"unobserved"})) {
    const auto numbers = NumbersAt(entry, {"direction"}, 6);
    if (!numbers) continue;
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> direction(numbers->data());
    if (!direction.allFinite() || direction.norm() == 0) continue;
    OpenDirection open;
    open.is_rotation = direction.tail<3>().norm() > direction.head<3>().norm();
    open.axis = (open.is_rotation ? direction.tail<3>() : direction.head<3>()).normalized();
    open.sigma = NumberAt(entry, {"sigma"});
    open.held_by = TextAt(entry, {"held_by"});
    list.push_back(open);
  }
  return list;
}

std::string InWords(const OpenDirection& open) {
  return (open.is_rotation ? "rotation about " : "translation along ") + AxisText(open.axis);
}

std::string HoldInWords(const OpenDirection& open) {
  if (!open.sigma) return "nothing holds it";
  const std::string sigma = open.is_rotation ? Significant(*open.sigma * kDegreesPerRadian, 2) + "°"
                                             : Significant(*open.sigma, 2) + "\u00a0m";
  const std::string holder = open.held_by == "gps" ? "GPS" : Escape(open.held_by);
  return "sigma " + sigma + (holder.empty() ? "" : " from " + holder);
}

Weakest WeakestAxis(const Matrix6& covariance, int first) {
  const Eigen::Matrix3d block = covariance.block<3, 3>(first, first);
  if (!block.allFinite()) {
    Eigen::Index open = 0;
    for (int i = 0; i < 3; ++i) open = std::isfinite(block(i, i)) ? open : i;
    return {std::numeric_limits<double>::infinity(), Eigen::Vector3d::Unit(open)};
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(block);
  Eigen::Vector3d axis = solver.eigenvectors().col(2);
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
  return {std::sqrt(std::max(0.0, solver.eigenvalues()[2])), axis};
}

}  // namespace planegraph
