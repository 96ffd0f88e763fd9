#include "pipeline/input_warnings.h"

#include <algorithm>

#include "planegraph/base/counted.h"
#include "planegraph/evaluation/trajectory_warnings.h"

namespace planegraph {

std::vector<std::string> OdometryWarnings(const Site& site) {
  std::vector<std::string> warnings;
  for (const RobotSite& robot : site.robots) {
    if (!robot.odometry) continue;
    const auto times = TimesWarning(*robot.odometry, robot.odometry_file);
    if (times) warnings.push_back(*times + ": line k belongs to scan k");
  }
  return warnings;
}

std::vector<std::string> UnitsWarnings(const Site& site, const std::vector<ScanRecord>& scans) {
  std::vector<std::string> warnings;
  for (std::size_t robot = 0; robot < site.robots.size(); ++robot) {
    const auto doubtful = std::count_if(scans.begin(), scans.end(), [&](const ScanRecord& scan) {
      return scan.robot == robot && scan.units_doubtful;
    });
    const std::size_t count = site.robots[robot].scans.size();
    if (2 * static_cast<std::size_t>(doubtful) <= count) continue;
    warnings.push_back(site.robots[robot].name + ": in " + Counted(doubtful, "scan") + " of " +
                       std::to_string(count) +
                       " half of the points are farther than 100 m: are the units metres?");
  }
  return warnings;
}

}  // namespace planegraph
