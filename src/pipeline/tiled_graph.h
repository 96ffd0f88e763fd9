#pragma once

#include <functional>
#include <vector>

#include "pipeline/graph_building.h"
#include "planegraph/pipeline/joint_solve.h"

namespace planegraph {

/// The maps whose site asks for tiles, all of them where the solution has the whole.
std::vector<BentMap> LayOutTiles(const JointProblem& problem, const JointSolution& solution);

/// What takes a place of a bent map to the world: its tile. Empty for a map without tiles.
std::function<const Sim3&(const Eigen::Vector3d& place)> PlaceInTiles(const JointSolution& solution,
                                                                      std::size_t map);

/// Puts the tiles of bent maps in their places: one node each, what was of the map goes to the tile
/// that holds its place (surfaces by their centroids, cameras by where they stand), the map's
/// direction upwards in equal shares to all; neighbours are tied. Maps that nothing is registered
/// to, and those without tiles, stay what they are. Where the tiles stand together the cost does
/// not change.
void CutMaps(const JointSolution& solution, Graph* graph);

/// Takes where maps and tiles stand over from a graph that BuildGraph and CutMaps have made.
void TakeMapsOver(const JointProblem& problem, const Graph& graph, JointSolution* solution);

/// Measures the errors of bent maps anew, where the last solve has their tiles: what is left of
/// them is what their surfaces count by in the next one. Without bent maps nothing changes.
void WeighBentMaps(const JointProblem& problem, const JointSolution& solution, MapWeights* weights,
                   AssociationOptions* association);

/// Covariances of the maps, of bent ones those of the similarity that is nearest to their tiles,
/// and how well each tile's place is known.
void ComputeMapCovariances(const GraphCovariance& covariance, MapResult* result);

}  // namespace planegraph
