#pragma once

#include <vector>

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// Poses along the used registrations with the most planes in common (a maximum spanning tree from
/// the first scan of each component), odometry where no registration leads on.
std::vector<Rigid3> ChainPoses(const Site& site, const std::vector<ScanRecord>& scans,
                               const std::vector<PairRecord>& pairs,
                               const std::vector<OdometryStep>& odometry);

/// Poses that agree best with all used registrations: a pose graph of relative poses, robust.
std::vector<Rigid3> SolveRelativePoses(const std::vector<PairRecord>& pairs,
                                       const std::vector<OdometryStep>& odometry,
                                       std::vector<Rigid3> start, int threads);

/// Association and solve in turns, from a wide gate to a narrow one, until no pose moves.
JointSolution SolveJointly(const std::vector<ScanRecord>& scans,
                           const std::vector<PairRecord>& pairs,
                           const std::vector<OdometryStep>& odometry,
                           const std::vector<Rigid3>& start, const MapOptions& options);

/// Covariances and open directions of the solution's poses. Information that noise of the normals
/// fakes along directions that all registrations of a scan leave open is taken out first.
void ComputeUncertainty(const std::vector<PairRecord>& pairs, const MapOptions& options,
                        MapResult* result);

/// Component of each scan, joined by used registrations; numbered by their first scans.
std::vector<int> Components(std::size_t scans, const std::vector<PairRecord>& pairs);

}  // namespace planegraph
