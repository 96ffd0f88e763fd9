#include "planegraph/pipeline/front_end.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>

#include "planegraph/base/error.h"
#include "planegraph/cloud/saturated_returns.h"
#include "planegraph/cloud/units.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

class Stopwatch {
 public:
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// A point far off everything is the file's error, not the program's.
Segmentation Segment(const Cloud& cloud, const std::string& file,
                     const SegmentationOptions& options) {
  try {
    return SegmentPlanes(cloud, options);
  } catch (const std::length_error& error) {
    throw InputError::InFile(file, error.what());
  }
}

double ReachOf(const Cloud& cloud) {
  double reach = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    reach = std::max(reach, (cloud.Position(i) - cloud.viewpoint).norm());
  }
  return reach;
}

std::string ScanId(const std::string& robot, std::size_t index) {
  char number[32];
  std::snprintf(number, sizeof(number), "/%03zu", index);
  return robot + number;
}

}  // namespace

LoadedScan LoadScan(const RobotSite& robot, std::size_t index) {
  LoadedScan scan;
  Stopwatch watch;
  scan.cloud = ReadCloud(robot.scans[index], robot.format);
  scan.points = scan.cloud.size();
  scan.seconds_read = watch.Lap();
  scan.cloud = FilterChain(robot.filters).Apply(DropSaturatedReturns(std::move(scan.cloud)));
  scan.seconds_preprocess = watch.Lap();
  return scan;
}

std::vector<std::size_t> OrderAlongWay(const RobotSite& robot) {
  std::vector<std::size_t> order(robot.scans.size());
  std::iota(order.begin(), order.end(), 0);
  if (!robot.odometry || !robot.odometry->has_times) return order;
  const std::vector<double>& times = robot.odometry->times;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return times[a] < times[b]; });
  return order;
}

ScanRecord PrepareScan(const Site& site, std::size_t robot_index, std::size_t index,
                       const SegmentationOptions& options) {
  const RobotSite& robot = site.robots[robot_index];
  const LoadedScan scan = LoadScan(robot, index);
  ScanRecord record;
  record.id = ScanId(robot.name, index);
  record.file = robot.scans[index];
  record.robot = robot_index;
  record.index = index;
  record.time = robot.odometry ? robot.odometry->times[index] : static_cast<double>(index);
  record.points = scan.points;
  record.points_filtered = scan.cloud.size();
  record.reach = ReachOf(scan.cloud);
  record.units_doubtful = AreUnitsDoubtful(scan.cloud);
  record.seconds_read = scan.seconds_read;
  record.seconds_preprocess = scan.seconds_preprocess;
  Stopwatch watch;
  Segmentation segmentation = Segment(scan.cloud, robot.scans[index], options);
  record.planes = std::move(segmentation.planes);
  record.labels = std::move(segmentation.labels);
  record.seconds_segment = watch.Lap();
  return record;
}

}  // namespace planegraph
