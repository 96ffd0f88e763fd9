// Registrations of consecutive scans against their odometry.
#include <gtest/gtest.h>

#include "pipeline/small_site.h"

namespace planegraph {
namespace {

class HallsOfEqualBays : public TestFolder, public testing::WithParamInterface<std::uint64_t> {};

// Six scans for a hall of 60 m: consecutive ones share little, and its bays of 10 m look alike. A
// pose that is a bay off was taken, against an odometry that is good to a few percent.
TEST_P(HallsOfEqualBays, AScanIsNotTakenForOneABayFurther) {
  SimulationOptions options;
  options.scene = SceneKind::kHall;
  options.seed = GetParam();
  options.scans = 6;
  options.drone_mode = DroneMode::kOff;
  const SimulatedSite site = Simulate(options);
  WriteSite(Path("hall"), site);
  const MapResult result = MapScans(ReadSite(Path("hall/site.yaml")), TwoThreads());
  EXPECT_LT(LargestDistance(result.solution.world_from_scan, TruthFromFirst(site)), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Seeds, HallsOfEqualBays, testing::Values(14, 210));

}  // namespace
}  // namespace planegraph
