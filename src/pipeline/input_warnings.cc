#include "pipeline/input_warnings.h"

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

}  // namespace planegraph
