#pragma once

#include <vector>

#include "planegraph/pipeline/joint_solve.h"

namespace planegraph {

/// Its inverse, also where directions of it are (numerically) known exactly.
Matrix6d PositiveInverse(const Matrix6d& covariance);

/// Adds the odometry's steps as relative poses, robust ones as a rule.
void AddOdometry(const std::vector<OdometryStep>& odometry, Graph* graph, bool robust = true);

/// Puts steps with the scale of each robot's odometry as an unknown of its own (node `i` of robot
/// i) in the place of AddOdometry's: what all steps err by in common is not found out by the number
/// of steps.
void ShareOdometryScales(const std::vector<OdometryStep>& odometry, std::size_t robots,
                         Graph* graph);

std::vector<Rigid3> PosesOf(const Graph& graph);

/// What the observations of each map count: see MapErrors and MapVarianceFactor.
struct MapWeights {
  std::vector<MapErrors> errors;
  std::vector<double> factors;
};

MapWeights WeighMaps(const JointProblem& problem);

/// Noise floors as the registrations measured them, and gates as wide as the maps' errors; the
/// first gate is for the scans to set.
AssociationOptions MeasuredAssociation(const JointProblem& problem);

/// Gates and floors of the maps' surfaces, by the maps' errors.
void AllowForMaps(const std::vector<MapErrors>& maps, AssociationOptions* options);

/// The graph of one round: scans and maps as nodes where the solution has them, their common planes
/// by association, odometry, GPS and starts.
Graph BuildGraph(const JointProblem& problem, const JointSolution& solution,
                 const AssociationOptions& association, const MapWeights& weights);

}  // namespace planegraph
