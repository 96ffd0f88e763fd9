#pragma once

#include <functional>
#include <string>
#include <vector>

#include "planegraph/pipeline/chain.h"
#include "planegraph/pipeline/front_end.h"
#include "planegraph/pipeline/map_front_end.h"
#include "planegraph/pipeline/robot_positions.h"
#include "planegraph/registration/map_registration.h"

namespace planegraph {

/// One registration of a scan to a drone map, whether it was used or not.
struct MapPairRecord {
  std::size_t map = 0, scan = 0;  ///< indices of maps and scans
  RegistrationStatus status = RegistrationStatus::kFailed;
  std::string reason;
  MapRefinement refinement;  ///< metric map frame from scan, the scale held
  MapEvidence evidence;
  std::size_t correspondences = 0;  ///< planes of the scan that found their counterpart
  bool used = false;
  double seconds = 0.0;
};

/// Where things stand: scans in frames of their own until a map (or a start) places them.
struct Placement {
  std::vector<Rigid3> world_from_scan;
  std::vector<Sim3> world_from_metric;  ///< of each map: from its metric frame to the world
  std::vector<bool> placed;             ///< of each scan: by a map
  std::vector<MapErrors> errors;        ///< of each map, as the scans found them
};

/// What placing works on; none of it is owned, all of it must outlive the call.
struct PlacementProblem {
  const Site& site;
  const std::vector<ScanModel>& models;
  const std::vector<ScanRecord>& scans;
  const std::vector<int>& component;  ///< of each scan, by registrations between scans
  const std::vector<OdometryStep>& odometry;
  const std::vector<MapRecord>& maps;
  const std::vector<MapModel>& map_models;
  const std::vector<RobotPosition>& robot_positions;
  int threads = 0;
  std::function<void(double)> progress = [](double) {};  ///< share done, from any thread
};

/// Places the components of scans (rigid groups, joined by registrations) in the maps: near the
/// start where there is one, or near what odometry says after another component of the robot, else
/// anywhere. The scale of a map is corrected by the first group that is found in it. Components
/// that are not found stay; the reason goes into *records, one for each of their scans.
void PlaceInMaps(const PlacementProblem& problem, Placement* placement,
                 std::vector<MapPairRecord>* records);

/// Registers every placed scan to the sections of the maps about it (steps f to h of the paper).
/// Scans that the map hardly covers are left alone, those that disagree with their group are
/// refused, each with the reason.
std::vector<MapPairRecord> RegisterToMaps(const std::vector<ScanModel>& models,
                                          const std::vector<MapModel>& map_models,
                                          const Placement& placement, int threads);

/// Variance of the used registrations' differences to the joint placement over what their own
/// covariances expect, at least 1 (robust; 4 with fewer than three): errors of a map that are
/// common to all that one scan sees of it.
double MapVarianceFactor(const std::vector<MapPairRecord>& records, const Placement& placement,
                         std::size_t map);
/// The same against where `metric_from_scan` has the scans.
double MapVarianceFactor(const std::vector<MapPairRecord>& records, std::size_t map,
                         const std::function<Sim3(std::size_t scan)>& metric_from_scan);

}  // namespace planegraph
