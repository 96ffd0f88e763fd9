#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/report/apart.h"
#include "report/json_access.h"

namespace planegraph {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// What pictures and tables both need of a scan; the rest stays in its JSON.
struct ReportScan {
  std::string id, robot, number;
  std::size_t robot_index = 0;  ///< of the robot, in the order of first scans
  std::optional<Eigen::Vector3d> position;
  std::optional<Matrix6> covariance;  ///< NaN where infinite
  std::optional<int> component;
  bool stands_apart = false;  ///< in another component than most scans
  const Json* json = nullptr;
};

/// The same of a drone map.
struct ReportMap {
  std::string id;
  std::size_t anchored = 0;  ///< scans that are
  const Json* json = nullptr;
};

/// What the planes leave open, as report.json says it.
struct OpenDirection {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  bool is_rotation = false;
  std::optional<double> sigma;  ///< metres or radians; nothing: infinite
  std::string held_by;          ///< empty: nothing
};

/// The 6x6 matrix under `covariance` of a scan or a registration, NaN where infinite.
std::optional<Matrix6> CovarianceOf(const Json& owner);

/// A report's JSON with what was read from it. The JSON outlives it.
struct ReportData {
  const Json* json = nullptr;
  std::vector<ReportScan> scans;
  std::vector<ReportMap> maps;
  std::vector<std::string> robots;
  bool is_whole = true;  ///< no scan stands apart

  /// The scan of that id, or null.
  const ReportScan* Find(const std::string& id) const;
  std::vector<Eigen::Vector3d> Positions() const;
};

/// Whether the others of its component are relative to it: it has no uncertainty.
bool IsFixed(const ReportScan& scan);

/// Whether nothing but the registrations that are missing would place scans that stand apart. A
/// component that GPS or a start holds has a place: none of its scans is fixed.
bool ApartPlacedByNothing(const ReportData& data);

/// The scans whose component is known.
std::vector<ComponentScan> ComponentScans(const ReportData& data);

/// The maps that a scan is anchored to.
std::vector<std::string> AnchorsOf(const Json& scan);

ReportData ReadReportData(const Json& json);

/// world_from_scan; nothing where the report has no usable pose.
std::optional<Rigid3> PoseOf(const ReportScan& scan);

/// The entries of `unobserved`; those that cannot be read are left out.
std::vector<OpenDirection> OpenDirections(const Json& owner);

/// "translation along (0.71, 0.70, 0.01)" or "rotation about (...)".
std::string InWords(const OpenDirection& open);
/// "sigma 0.80 m, held by odometry", or what stands for it where nothing is known.
std::string HoldInWords(const OpenDirection& open);

/// The longest half axis of the 1-sigma ellipsoid of the position (`first` 0) or rotation (3)
/// block, and its direction. Sigma is infinite where a variance is.
struct Weakest {
  double sigma = 0.0;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
};
Weakest WeakestAxis(const Matrix6& covariance, int first);

}  // namespace planegraph
