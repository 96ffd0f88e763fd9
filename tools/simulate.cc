// `planegraph simulate`: a site with exact truth.
#include <gflags/gflags.h>

#include <iostream>

#include "planegraph/simulation/simulation.h"
#include "tools/command.h"
#include "tools/common_flags.h"

DEFINE_string(scene, "yard", "hall, corridor or yard");
DEFINE_int32(scan_count, 0, "number of scans (0: as many as suit the scene)");
DEFINE_int32(beams, 541, "beams per sweep, over 270 degrees");
DEFINE_int32(sweeps, 180, "sweeps per scan, over 180 degrees");
DEFINE_double(scanner_range, 35.0, "range of the scanner, metres");
DEFINE_bool(noise_free, false, "exact ranges, no drop-outs, no mixed pixels");

namespace planegraph::tools {
namespace {

SimulationOptions OptionsFromFlags() {
  SimulationOptions options;
  options.scene = ParseSceneKind(FLAGS_scene);
  options.seed = FLAGS_seed;
  options.scans = FLAGS_scan_count;
  options.threads = FLAGS_threads;
  options.scanner.beams = FLAGS_beams;
  options.scanner.sweeps = FLAGS_sweeps;
  options.scanner.max_range = FLAGS_scanner_range;
  if (FLAGS_noise_free) options.scanner = options.scanner.WithoutNoise();
  return options;
}

int Run(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 0, 0);
  RequireFlag("output_dir");
  const SimulatedSite site = Simulate(OptionsFromFlags());
  WriteSite(FLAGS_output_dir, site);
  nlohmann::json scans = nlohmann::json::array();
  std::size_t total = 0;
  for (const LabelledScan& scan : site.scans) {
    scans.push_back({{"points", scan.cloud.size()}});
    total += scan.cloud.size();
  }
  if (WantsText()) {
    std::cout << site.name << ": " << scans.size() << " scans, " << total << " points, "
              << site.planes.size() << " planes in " << FLAGS_output_dir << "\n";
  }
  EmitResult({{"scene", FLAGS_scene},
              {"site", FLAGS_output_dir + "/site.yaml"},
              {"scan_count", scans},
              {"planes", site.planes.size()}},
             false);
  return 0;
}

}  // namespace

Command SimulateCommand() {
  return {"simulate",
          "--scene=hall|corridor|yard --output_dir=DIR",
          "make a site with exact truth: scans, odometry, labels",
          {"scene", "output_dir", "scan_count", "beams", "sweeps", "scanner_range", "noise_free"},
          Run};
}

}  // namespace planegraph::tools
