#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/registration/registration.h"

namespace planegraph {

/// A plane as the closed form sees it, in its cloud's frame.
struct FittedPlane {
  Eigen::Vector3d normal;    ///< unit
  Eigen::Vector3d centroid;  ///< a point of the plane near the middle of what was seen
  /// Covariance of the normal, in its tangent plane (normal^T C = 0).
  Eigen::Matrix3d normal_covariance;
  double offset_variance;  ///< of the plane's height at the centroid, m^2

  /// Isotropic variance of the tilt, rad^2.
  double TiltVariance() const { return 0.5 * normal_covariance.trace(); }
};
FittedPlane MakeFittedPlane(const PlaneSegment& segment);

/// One plane of the target and one of the source that are the same surface, facing the same way.
struct PlaneMatch {
  FittedPlane target, source;
};

/// What is known of the rotation from elsewhere, as data.
struct RotationPrior {
  Eigen::Quaterniond target_from_source;
  double sigma;  ///< radians, the same about every axis
};

struct RotationSolution {
  Eigen::Quaterniond target_from_source;
  Eigen::Matrix3d covariance;   ///< of the left perturbation, rad^2; a free direction has 1e6
  Eigen::Matrix3d information;  ///< its inverse, with zeros for free directions
  /// s2 + det(U) det(V) s3 of the singular values s1 >= s2 >= s3 of sum(w n_target n_source^T),
  /// divided by s1: the optimum is unique iff it is positive.
  double uniqueness = 0.0;
  bool unique = false;
};

/// Rotation that minimizes sum w_i |R n_source - n_target|^2, w_i = 1 / (sum of both tilt
/// variances), by SVD with the determinant corrected (Arun et al. 1987, Umeyama 1991). Where the
/// normals leave it free and there is no prior it stays nearest to the identity. The prior enters
/// as R_prior / (2 sigma^2), which is exact for small angles.
RotationSolution SolveRotation(const std::vector<PlaneMatch>& matches,
                               const std::optional<RotationPrior>& prior = {});

/// What becomes of the directions of translation that the planes leave open.
enum class OpenDirections {
  kSoftPrior,   ///< the prior counts everywhere, by its covariance
  kProjection,  ///< rank decision; the prior counts there alone, as it is (Surmann et al., eq. (2))
};

struct ClosedFormOptions {
  OpenDirections open = OpenDirections::kSoftPrior;
  /// Rule 1 of the rank decision: a direction is observed if its standard deviation is below this,
  /// metres (and below the prior's own, where there is one).
  double most_sigma = 0.1;
  /// Rule 2: and if its information is above this many times what noise of the normals would fake.
  double spurious_factor = 9.0;
  double weak_rotation = 0.026;  ///< radians: a larger standard deviation is "not observed"
};

struct TranslationPrior {
  Eigen::Vector3d translation;
  Eigen::Matrix3d covariance;
};

struct TranslationSolution {
  Eigen::Vector3d translation;
  Eigen::Matrix3d covariance;   ///< without the rotation's share, m^2; an open direction has 1e6
  Eigen::Matrix3d sensitivity;  ///< d translation / d rotation vector
  int rank = 0;
  Eigen::Matrix3d directions;       ///< columns: right singular vectors, the best observed first
  Eigen::Vector3d singular_values;  ///< of the whitened rows, 1/m: inverse standard deviations
};

/// Translation from the heights of the planes with the rotation known. Rows are written at the
/// centroids and symmetrically: mean normal . (R c_source + t - c_target) = 0, whitened by the
/// variance of both heights, of the normals over the distance between the centroids, and of the
/// rotation. Every singular direction is divided by its own singular value; the estimate's part in
/// the missing directions is a projection, without any. (The paper prints sigma_1 in all terms of
/// both sums.)
TranslationSolution SolveTranslation(const std::vector<PlaneMatch>& matches,
                                     const RotationSolution& rotation,
                                     const ClosedFormOptions& options = {},
                                     const std::optional<TranslationPrior>& prior = {});

struct ClosedFormPose {
  Rigid3 target_from_source;
  Matrix6d covariance;  ///< INTERFACE order; directions that nothing holds have 1e6
  int rank = 0;         ///< of the translation by the planes alone
  bool unique_rotation = false;
  /// Directions that the planes leave open, with the standard deviation of the pose along them.
  std::vector<UnobservedDirection> unobserved;
};

/// Rotation, then translation. `held_by` names the prior in the unobserved directions.
ClosedFormPose SolveClosedForm(const std::vector<PlaneMatch>& matches,
                               const ClosedFormOptions& options = {},
                               const std::optional<PosePrior>& prior = {},
                               const std::string& held_by = "prior");

}  // namespace planegraph
