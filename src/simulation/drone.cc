#include "planegraph/simulation/drone.h"

#include "planegraph/simulation/random.h"
#include "simulation/streams.h"

namespace planegraph {

SimulatedDrone SimulateDrone(const Scene& scene, const RayCaster& caster,
                             const DroneOptions& options, std::uint64_t seed, int threads) {
  SimulatedDrone drone;
  drone.origin = options.origin;
  Random flight_random(seed, kFlightStream), gps_random(seed, kGpsStream);
  drone.flight = PlanFlight(scene.area_low, scene.area_high, options.flight, &flight_random);
  drone.model = Reconstruct(caster, drone.flight, options.photogrammetry, seed, threads);
  drone.gps = SimulateGps(drone.flight, options.gps, &gps_random);
  return drone;
}

}  // namespace planegraph
