#pragma once

#include <cstddef>
#include <string>

#include "planegraph/io/g2o_io.h"
#include "planegraph/pose_graph/pose_graph.h"

namespace planegraph {

/// What becomes of the information matrices of a file. kFile: taken as they are; kIsotropic:
/// SE-Sync's tau and kappa of each; kNearest: the nearest positive semi-definite matrix (negative
/// eigenvalues become zero).
enum class InformationUse { kFile, kIsotropic, kNearest };

/// The rotation error that the information matrices of an SE(3) file belong to: kHalf, g2o's vector
/// part of the quaternion, about half the angle; kFull: twice that, as Ceres' example and GTSAM
/// read the same files. The planar edges' error is the angle in both.
enum class RotationError { kHalf, kFull };

struct G2oConversionOptions {
  InformationUse information = InformationUse::kFile;
  RotationError rotation_error = RotationError::kHalf;
};

/// What was found in the information matrices.
struct InformationReport {
  std::size_t indefinite =
      0;              ///< with a clearly negative eigenvalue (relative to the largest, 1e-9)
  std::string first;  ///< "edge 3-7", the first of them
};

/// Edges of the file whose information matrix is no such matrix.
InformationReport CheckInformation(const G2oGraph& file);

/// Whether all vertices and edges are planar (SE(2)), or all of SE(3). Throws InputError, naming
/// `path`, for a mixture, and for a graph without edges.
bool IsPlanar(const G2oGraph& file, const std::string& path);

/// The pose graph of a file's vertices (in their order) and edges. Edges between consecutive ids
/// are odometry, all others robust. Priors (EDGE_SE3_PRIOR, EDGE_PRIOR_SE2) become edges from one
/// further, fixed pose at the identity, after the others. Throws InputError, naming `path`, for an
/// edge from a vertex to itself; with kFile where an information matrix is indefinite; with
/// kIsotropic where an edge has no positive weights.
template <int Dim>
PoseGraph<Dim> MakePoseGraph(const G2oGraph& file, const std::string& path,
                             const G2oConversionOptions& options = {});

/// Writes the poses of a graph made by MakePoseGraph into the file's vertices.
template <int Dim>
void StorePoses(const PoseGraph<Dim>& graph, G2oGraph* file);

}  // namespace planegraph
