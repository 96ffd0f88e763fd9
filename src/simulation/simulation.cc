#include "planegraph/simulation/simulation.h"

#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"

namespace planegraph {
namespace {

constexpr std::uint64_t kOdometryStream = 3, kFirstScanStream = 1000;

int CountScans(const SimulationOptions& options, const Scene& scene) {
  constexpr int kMostScans = 1000;  // three digits in the files' names
  if (options.scans < 0 || options.scans > kMostScans) {
    throw UsageError("the number of scans must lie in 1 to 1000 (0: the scene's own)");
  }
  return options.scans > 0 ? options.scans : scene.scans;
}

// The robot stands still for a scan and then drives on at half a metre per second.
std::vector<double> TimeStamps(const std::vector<Rigid3>& poses) {
  constexpr double kStart = 1000.0, kScanTime = 10.0, kSpeed = 0.5;
  std::vector<double> times(poses.size(), kStart);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double way = (poses[k].translation - poses[k - 1].translation).norm();
    times[k] = times[k - 1] + kScanTime + way / kSpeed;
  }
  return times;
}

}  // namespace

SimulatedSite Simulate(const SimulationOptions& options) {
  const Scene scene = BuildScene(options.scene, options.seed, options.scanner.max_range);
  const RayCaster caster(scene.mesh);
  SimulatedSite site;
  site.name = "simulated " + SceneName(options.scene) + ", seed " + std::to_string(options.seed);
  site.planes = scene.mesh.planes;
  site.truth = DrivePath(scene, caster, CountScans(options, scene), options.pose, options.seed);
  site.times = TimeStamps(site.truth);
  Random odometry_random(options.seed, kOdometryStream);
  site.odometry = SimulateOdometry(site.truth, options.odometry, &odometry_random);
  site.scans.resize(site.truth.size());
  ParallelFor(site.scans.size(), options.threads, [&](std::size_t k) {
    Random random(options.seed, kFirstScanStream + k);
    site.scans[k] = Scan(caster, site.truth[k], options.scanner, &random);
  });
  return site;
}

}  // namespace planegraph
