#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "planegraph/graph/graph.h"
#include "planegraph/registration/unobserved_direction.h"
#include "planegraph/solve/observability.h"
#include "planegraph/solve/solver.h"

namespace planegraph {

/// What says how large the noise of the planes' observations is.
enum class CovarianceNoise {
  kStated,    ///< their weights
  kResiduals  ///< their residuals over their redundancy, with the robust loss's own covariance
};

std::string Name(CovarianceNoise noise);
/// By its name, `stated` or `residuals`; throws UsageError.
CovarianceNoise ParseCovarianceNoise(const std::string& name);

struct CovarianceOptions {
  CovarianceNoise noise = CovarianceNoise::kStated;
  /// A direction of a pose counts as unobserved where the planes alone leave it a sigma above this.
  double translation_threshold = 0.1;  ///< metres
  double rotation_threshold = 0.0175;  ///< radians (1 deg)
  double scale_threshold = 0.01;       ///< of a map, relative
};

/// Covariances of a solved graph, relative to what the gauge fixes (SolveOptions and GaugeFixed as
/// in Solve), by Schur's complement of the planes and a sparse Cholesky factorization. All 6x6
/// matrices are in the project's convention: order x y z rx ry rz, decoupled left perturbation,
/// target's (world's) axes, metres and radians. Robust losses enter by their weights at the
/// solution; with noise by the residuals, by their second derivatives, too: the covariance of an
/// M-estimator (Huber 1967), A^-1 B A^-1 (how: solve/residual_scatter.h). What the planes leave
/// open (Unobserved, OpenMotions: which directions) goes by the stated noise always.
///
/// What ties two maps is of their shape, not of where they stand: with the planes it says what is
/// observed.
class GraphCovariance {
 public:
  explicit GraphCovariance(const Graph& graph, const SolveOptions& options = {},
                           const CovarianceOptions& covariance_options = {});
  ~GraphCovariance();

  /// Covariance of world_from_node; zero for a fixed pose. Rows and columns of axes along which
  /// nothing holds the pose are NaN.
  Matrix6d Pose(int pose) const;
  /// Covariance of target_from_source; NaN as above.
  Matrix6d Relative(int target, int source) const;
  /// Joint covariance of target_from_source for several sources, 6 rows each in their order; NaN as
  /// above.
  Eigen::MatrixXd Relatives(int target, const std::vector<int>& sources) const;
  /// Covariance of world_from_map (order x y z rx ry rz log(scale)); zero for a fixed map;
  /// NaN as above.
  Matrix7d Map(int map) const;
  /// Covariance of a similarity that moves with several maps, say tiles of one, by its derivative
  /// by each of them; NaN as above.
  Matrix7d MapMean(const std::vector<std::pair<int, Matrix7d>>& by_maps) const;
  /// Variance of Graph::scales[scale].
  double Scale(int scale) const;
  /// Covariance of a plane in the tangent space of its landmark (the normal along the two columns
  /// of TangentBasis(normal), the offset from the anchor; radians and metres). NaN for a plane
  /// whose observations leave something of it open, or that is no unknown of the plane factor.
  Eigen::Matrix3d Plane(int plane) const;
  /// What the planes leave open at this pose, translations first, the weakest first.
  std::vector<UnobservedDirection> Unobserved(int pose) const;
  /// What the planes of the whole graph leave open, each motion once for all nodes that share it.
  std::vector<OpenMotion> OpenMotions() const;
  const CovarianceOptions& options() const;
  /// What the planes leave open of target_from_source, in the target's axes.
  std::vector<UnobservedDirection> UnobservedRelative(int target, int source) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace planegraph
