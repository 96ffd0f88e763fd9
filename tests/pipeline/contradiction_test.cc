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

// In a corridor a few patches that face along it matched others, 0.5 m from where the odometry was:
// the pose came out 0.39 m wrong, and sure to a centimetre.
TEST_F(TestFolder, AHandfulOfPatchesHoldsNoDirection) {
  SimulationOptions options;
  options.scene = SceneKind::kCorridor;
  options.seed = 950;
  options.scans = 8;
  options.scanner.beams = 271;
  options.scanner.sweeps = 90;
  options.drone_mode = DroneMode::kOff;
  const SimulatedSite site = Simulate(options);
  WriteSite(Path("corridor"), site);
  const MapResult result = MapScans(ReadSite(Path("corridor/site.yaml")), TwoThreads());
  const std::vector<Rigid3>& truth = site.robots[0].truth;
  for (const PairRecord& pair : result.pairs) {
    if (!pair.used || !pair.registration.unobserved.empty()) continue;
    const Rigid3 off = pair.registration.target_from_source() *
                       (truth[pair.source].Inverse() * truth[pair.target]);
    EXPECT_LT(off.translation.norm(), 0.05) << pair.target << " to " << pair.source;
  }
}

}  // namespace
}  // namespace planegraph
