#pragma once

#include <cstdint>

#include "planegraph/io/local_frame.h"
#include "planegraph/simulation/flight.h"
#include "planegraph/simulation/gps.h"
#include "planegraph/simulation/photogrammetry.h"
#include "planegraph/simulation/scene.h"

namespace planegraph {

struct DroneOptions {
  FlightOptions flight;
  PhotogrammetryOptions photogrammetry;
  GpsOptions gps;
  GeodeticPosition origin{51.488, 7.493, 115.0};  ///< where the world's zero lies
};

/// What a drone brings home, and the truth about it.
struct SimulatedDrone {
  Flight flight;  ///< truth
  PhotogrammetryModel model;
  SimulatedGps gps;
  GeodeticPosition origin;
};

/// Flies over the scene's area. The result is the same for every number of threads. Throws
/// UsageError for options that make no sense.
SimulatedDrone SimulateDrone(const Scene& scene, const RayCaster& caster,
                             const DroneOptions& options, std::uint64_t seed, int threads);

/// Writes uav/cloud.ply (as MVE does: float x y z nx ny nz, uchar red green blue, float confidence
/// value), uav/synth_0.out (MVE's bundle), uav/images.csv, uav/gps.csv, and the truth:
/// truth/similarity.json, truth/uav_cameras.tum, truth/labels/uav_cloud.ply (the cloud's points
/// with the int properties `plane`, -1: none, and `view`). Throws InputError.
void WriteDrone(const std::string& folder, const SimulatedDrone& drone);

}  // namespace planegraph
