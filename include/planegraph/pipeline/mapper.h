#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "planegraph/pipeline/chain.h"
#include "planegraph/pipeline/map_front_end.h"
#include "planegraph/pipeline/map_matching.h"
#include "planegraph/pipeline/map_tiling.h"
#include "planegraph/pipeline/robot_positions.h"
#include "planegraph/pipeline/site.h"
#include "planegraph/pipeline/switched_off.h"
#include "planegraph/solve/association.h"
#include "planegraph/solve/covariance.h"
#include "planegraph/solve/marginal_graph.h"
#include "planegraph/solve/solver.h"

namespace planegraph {

/// Reports a stage and how much of it is done, in [0, 1].
using Progress = std::function<void(const std::string& stage, double done)>;

struct MapOptions {
  std::string optimizer = "graph";  ///< graph, metascan, none
  std::string plane_factor = "moments";
  FactorOptions plane_factor_options;
  LossSpec loss{"cauchy", 2.4};  ///< of the planes; measurements of poses and maps: cauchy:2.4
  std::map<std::string, LossSpec> factor_losses;             ///< others, by the factor's name
  CovarianceNoise covariance = CovarianceNoise::kResiduals;  ///< of what is reported
  int threads = 0;
  MapMemory map_memory;
  SegmentationOptions segmentation;
  RegistrationOptions registration;
  std::size_t neighbours_per_scan = 4;
  int most_rounds = 6;  ///< of association and solve
  double stable =
      5e-4;  ///< metres, or the scans' noise floor: a round that moves no pose farther is the last
  Progress progress = [](const std::string&, double) {};
  /// Is given each warning when it arises, long before all are in MapResult::warnings.
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};

/// Loss of the plane factor, or of the measurements of one type.
const LossSpec& PlaneLoss(const MapOptions& options);
LossSpec MeasurementLoss(const MapOptions& options, const std::string& factor);
/// All losses, as ParseFactorLosses reads them.
std::string LossText(const MapOptions& options);

/// What the joint solve left behind.
struct JointSolution {
  std::vector<Rigid3> world_from_scan;
  std::vector<Sim3> world_from_metric;  ///< of each map; of a bent one the nearest similarity
  std::vector<BentMap> bent_maps;       ///< by map; without a grid where it has no tiles
  Graph graph;                          ///< with the landmarks of the last round
  SolveSummary summary;
  std::vector<std::vector<double>> costs;  ///< of every solve: each has an association of its own
  double floor_offset = 0.0, floor_tilt = 0.0;  ///< noise floors measured between scans
  std::vector<SwitchedOff> switched_off;        ///< by the loss of the last solves
  int rounds = 0;
  double last_move = 0.0;  ///< metres: how far the last solve moved a pose at most
  double seconds = 0.0;
};

struct StageSeconds {
  double front_end = 0, maps = 0, pairing = 0, placing = 0, solve = 0, covariance = 0, output = 0;
};

/// All that `planegraph map` knows at the end.
struct MapResult {
  Site site;
  std::vector<ScanRecord> scans;
  std::vector<PairRecord> pairs;
  std::vector<OdometryStep> odometry;         ///< scaled by odometry_scales
  std::vector<double> odometry_scales;        ///< by robot, true metres in a metre of its odometry
  std::vector<double> odometry_scale_sigmas;  ///< by robot; empty without the covariance
  std::vector<MapRecord> maps;
  std::vector<MapPairRecord> map_pairs;
  std::vector<RobotPosition> robot_positions;  ///< by GPS, world
  std::vector<SwitchedOff> refused;            ///< registrations, before the joint solve
  JointSolution solution;
  std::vector<Matrix6d> covariances;      ///< by scan; NaN where infinite
  std::vector<Matrix7d> map_covariances;  ///< by map, of world_from_map
  /// By map and tile: of its middle off world_from_map, in the worst direction, metres.
  std::vector<std::vector<double>> tile_sigmas;
  std::shared_ptr<const GraphCovariance> covariance;  ///< of the graph; null without one
  std::vector<MarginalEdge> bridges;  ///< between scans that maps alone join, for the pose graph
  std::vector<std::vector<UnobservedDirection>> unobserved;
  std::vector<int> component;  ///< of each scan: joined by used registrations, maps included
  int components = 0;
  StageSeconds seconds;
  std::vector<std::string> warnings;
};

/// The main job: scans to poses. The steps are those of the paper's figure with the joint graph in
/// place of the metascan. Throws InputError, UsageError.
MapResult MapScans(const Site& site, const MapOptions& options);

/// A robot's scans as indices into MapResult::scans (which are in the order of time), in the order
/// of its files: line k of a trajectory belongs to file k.
std::vector<std::size_t> ScansInFileOrder(const MapResult& result, std::size_t robot);

}  // namespace planegraph
