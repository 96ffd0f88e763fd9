// `planegraph simulate`: a site with exact truth.
#include <gflags/gflags.h>

#include <iostream>

#include "planegraph/simulation/simulation.h"
#include "tools/command.h"
#include "tools/common_flags.h"

DEFINE_string(scene, "yard", "hall, corridor, yard or quarter");
DEFINE_string(drone, "auto", "fly over the site: on, off, or auto (yard and quarter)");
DEFINE_int32(scan_count, 0, "scans of each robot (0: as many as suit the scene)");
DEFINE_int32(beams, 541, "beams per sweep, over 270 degrees");
DEFINE_int32(sweeps, 180, "sweeps per scan, over 180 degrees");
DEFINE_double(scanner_range, 35.0, "range of the scanner, metres");
DEFINE_bool(noise_free, false, "exact ranges and depths, no drop-outs, no mixed pixels");

namespace planegraph::tools {
namespace {

SimulationOptions SimulationOptionsFromFlags() {
  SimulationOptions options;
  options.scene = ParseSceneKind(FLAGS_scene);
  options.drone_mode = ParseDroneMode(FLAGS_drone);
  options.seed = FLAGS_seed;
  options.scans = FLAGS_scan_count;
  options.threads = FLAGS_threads;
  options.scanner.beams = FLAGS_beams;
  options.scanner.sweeps = FLAGS_sweeps;
  options.scanner.max_range = FLAGS_scanner_range;
  if (FLAGS_noise_free) {
    options.scanner = options.scanner.WithoutNoise();
    options.drone.photogrammetry = options.drone.photogrammetry.WithoutNoise();
  }
  return options;
}

nlohmann::json ScanTable(const SimulatedSite& site, std::size_t* points) {
  nlohmann::json scans = nlohmann::json::array();
  for (const SimulatedRobot& robot : site.robots) {
    for (const LabelledScan& scan : robot.scans) {
      scans.push_back({{"robot", robot.name}, {"points", scan.cloud.size()}});
      *points += scan.cloud.size();
    }
  }
  return scans;
}

nlohmann::json DroneTable(const SimulatedSite& site) {
  if (!site.drone) return nullptr;
  return {{"images", site.drone->flight.times.size()},
          {"points", site.drone->model.cloud.size()},
          {"fixes", site.drone->gps.times.size()}};
}

void Print(const SimulatedSite& site, std::size_t scans, std::size_t points) {
  std::cout << site.name << ": " << scans << " scans, " << points << " points, "
            << site.planes.size() << " planes";
  if (site.drone) {
    std::cout << "; a drone's map of " << site.drone->model.cloud.size() << " points from "
              << site.drone->flight.times.size() << " images";
  }
  std::cout << " in " << FLAGS_output_dir << "\n";
}

int RunSimulate(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 0, 0);
  RequireFlag("output_dir");
  const SimulatedSite site = Simulate(SimulationOptionsFromFlags());
  WriteSite(FLAGS_output_dir, site);
  std::size_t points = 0;
  const nlohmann::json scans = ScanTable(site, &points);
  if (WantsText()) Print(site, scans.size(), points);
  EmitResult({{"scene", FLAGS_scene},
              {"site", FLAGS_output_dir + "/site.yaml"},
              {"scan_count", scans},
              {"drone", DroneTable(site)},
              {"planes", site.planes.size()}},
             false);
  return 0;
}

}  // namespace

Command SimulateCommand() {
  return {"simulate",
          "--scene=hall|corridor|yard|quarter --output_dir=DIR",
          "make a site with exact truth: scans, odometry, a drone's map, labels",
          {"scene", "output_dir", "scan_count", "beams", "sweeps", "scanner_range", "noise_free",
           "drone"},
          RunSimulate};
}

}  // namespace planegraph::tools
