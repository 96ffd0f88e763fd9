#pragma once

#include <vector>

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// Poses along the used registrations with the most planes in common (a maximum spanning tree from
/// the first scan of each component), odometry where no registration leads on.
std::vector<Rigid3> ChainPoses(const Site& site, const std::vector<ScanRecord>& scans,
                               const std::vector<PairRecord>& pairs,
                               const std::vector<OdometryStep>& odometry);

/// Poses that agree best with all used registrations: a pose graph of relative poses, robust. With
/// a graduated loss (of relative poses, else of the planes) odometry is trusted, loops that are
/// right or wrong together (GroupClosures) have one weight, and registrations that end without one
/// are taken out of `pairs`, as `ambiguous`, and listed in *off.
std::vector<Rigid3> SolveRelativePoses(const std::vector<ScanRecord>& scans,
                                       const std::vector<OdometryStep>& odometry,
                                       std::vector<Rigid3> start, const MapOptions& options,
                                       std::vector<PairRecord>* pairs,
                                       std::vector<SwitchedOff>* off);

/// What the joint solve starts from: scans, their registrations to each other and to the maps, and
/// where everything stands so far.
struct JointProblem {
  const Site* site = nullptr;
  const std::vector<ScanRecord>* scans = nullptr;
  const std::vector<PairRecord>* pairs = nullptr;
  const std::vector<OdometryStep>* odometry = nullptr;
  const std::vector<MapRecord>* maps = nullptr;
  const std::vector<MapPairRecord>* map_pairs = nullptr;
  const Placement* placement = nullptr;
  const std::vector<RobotPosition>* robot_positions = nullptr;
};

/// Association and solve in turns, from a wide gate to a narrow one, until no pose moves: ONE graph
/// of scan poses, drone maps with their scales, and planes.
JointSolution SolveJointly(const JointProblem& problem, const MapOptions& options);

/// Covariances and open directions of the solution's poses. Information that noise of the normals
/// fakes along directions that all registrations of a scan leave open is taken out first.
void ComputeUncertainty(const std::vector<PairRecord>& pairs, const MapOptions& options,
                        MapResult* result);

/// Component of each scan, joined by used registrations, those to maps included; numbered by their
/// first scans.
std::vector<int> Components(std::size_t scans, const std::vector<PairRecord>& pairs,
                            const std::vector<MapPairRecord>& map_pairs = {});

}  // namespace planegraph
