#include "planegraph/pipeline/robot_positions.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "planegraph/base/median.h"
#include "planegraph/io/gps_io.h"
#include "registration/fix_track.h"

namespace planegraph {
namespace {

constexpr double kMaxGap = 5.0, kNearest = 1.0;  // seconds
constexpr double kCorrelationTime = 40.0;        // seconds, of a receiver's errors

const MapRecord* PlacedMapOf(const std::vector<MapRecord>& maps) {
  const auto found = std::find_if(maps.begin(), maps.end(),
                                  [](const MapRecord& map) { return map.has_position(); });
  return found == maps.end() ? nullptr : &*found;
}

std::optional<Eigen::Vector3d> PositionAt(const FixTrack& track, double time) {
  if (const auto moving = track.Interpolate(time, kMaxGap)) return moving->position;
  const FixTrack::Fix* nearest = track.Nearest(time);
  if (nearest == nullptr || std::abs(nearest->time - time) > kNearest) return {};
  return nearest->in_world;
}

// Of a first-order Gauss-Markov process that is sampled so often, in the mean of many.
double Inflation(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < times.size(); ++k) steps.push_back(times[k] - times[k - 1]);
  const double kept = std::exp(-Median(std::move(steps), kCorrelationTime) / kCorrelationTime);
  return std::min((1.0 + kept) / (1.0 - kept), std::max(1.0, 1.0 * times.size()));
}

void AddRobot(const Site& site, std::size_t robot, const FixTrack& track,
              const std::vector<ScanRecord>& scans, std::vector<RobotPosition>* positions) {
  const RobotSite& source = site.robots[robot];
  const std::vector<double>& all = source.odometry->times;
  if (all.empty()) return;
  const auto ends = std::minmax_element(all.begin(), all.end());
  const double day_shift = track.DayShift(*ends.first, *ends.second);
  std::vector<double> times;
  const std::size_t first = positions->size();
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].robot != robot) continue;
    const double time = source.odometry->times[scans[i].index];
    const auto position = PositionAt(track, time + day_shift);
    if (!position) continue;
    positions->push_back({i, source.gps->lever, *position, source.gps->sigma, 1.0});
    times.push_back(time);
  }
  const double inflation = Inflation(times);
  for (std::size_t k = first; k < positions->size(); ++k) (*positions)[k].inflation = inflation;
}

}  // namespace

std::vector<RobotPosition> ReadRobotPositions(const Site& site,
                                              const std::vector<ScanRecord>& scans,
                                              const std::vector<MapRecord>& maps,
                                              std::vector<std::string>* warnings) {
  std::vector<RobotPosition> positions;
  const MapRecord* map = PlacedMapOf(maps);
  for (std::size_t r = 0; r < site.robots.size(); ++r) {
    const RobotSite& robot = site.robots[r];
    if (!robot.gps) continue;
    const GpsTrack track = ReadGps(robot.gps->file);
    if (map == nullptr || (!track.metric && !map->georeference->origin)) {
      warnings->push_back(robot.name + ": its GPS is not used: no drone map ties the world to it");
      continue;
    }
    const std::size_t before = positions.size();
    AddRobot(site, r, FixTrack(track, map->georeference->origin), scans, &positions);
    if (positions.size() == before) {
      warnings->push_back(robot.name + ": no fix of its GPS is near the time of a scan");
    }
  }
  return positions;
}

}  // namespace planegraph
