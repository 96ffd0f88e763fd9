#include "pipeline/configuration_json.h"

#include "planegraph/base/angles.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

Json FiltersJson(const RobotSite& robot) {
  Json list = Json::array();
  for (const FilterStep& step : robot.filters) list.push_back({{step.name, step.parameters}});
  return list;
}

Json NoiseJson(const OdometryNoise& noise) {
  return {{"step", noise.step},         {"per_metre", noise.per_metre},
          {"scale", noise.scale},       {"step_deg", noise.step_rotation / kDegree},
          {"per_turn", noise.per_turn}, {"per_metre_deg", noise.rotation_per_metre / kDegree}};
}

}  // namespace

nlohmann::json ConfigurationJson(const MapResult& result, const MapOptions& options) {
  const SegmentationOptions& segmentation = options.segmentation;
  Json json = {{"optimizer", options.optimizer},
               {"plane_factor", options.plane_factor},
               {"loss", LossText(options)},
               {"covariance", Name(options.covariance)},
               {"neighbours_per_scan", options.neighbours_per_scan},
               {"most_rounds", options.most_rounds},
               {"segmentation",
                {{"cell_size", segmentation.cell_size},
                 {"min_points", segmentation.min_points},
                 {"min_area", segmentation.min_area}}}};
  for (const RobotSite& robot : result.site.robots) {
    json["robots"][robot.name] = {{"scans", robot.scans.size()},
                                  {"format", robot.format},
                                  {"odometry", robot.odometry.has_value()},
                                  {"odometry_noise", NoiseJson(robot.odometry_noise)},
                                  {"start", robot.start.has_value()},
                                  {"reference", !robot.reference.empty()},
                                  {"filters", FiltersJson(robot)}};
  }
  return json;
}

}  // namespace planegraph
