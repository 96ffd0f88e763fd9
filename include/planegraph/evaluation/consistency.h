#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace planegraph {

// Whether errors are as large as their covariances say (Bar-Shalom, Li and Kirubarajan 2001,
// "Estimation with Applications to Tracking and Navigation", 5.4).

/// An error in units of its covariance: e^T C^-1 e, chi-square with that many degrees of freedom
/// where the covariance is honest.
struct NormalizedError {
  double squared = 0.0;
  int degrees = 0;
};

/// Over the components whose variance is finite and above zero: what is unobserved cannot be wrong,
/// and what is held has no error of its own. Nothing where none is left, or where the covariance of
/// those is not positive definite.
std::optional<NormalizedError> Normalize(const Eigen::VectorXd& error,
                                         const Eigen::MatrixXd& covariance);

/// The probabilities of the regions whose coverage is counted.
inline constexpr std::array<double, 3> kCoverageLevels = {0.5, 0.9, 0.95};

/// The share of errors that lie in the region (the ellipsoid of chi-square's quantile) of each
/// level; `errors` is not empty.
std::array<double, 3> Coverage(const std::vector<NormalizedError>& errors);

/// How consistent the errors of several poses, or of the scales of maps, are.
struct Consistency {
  std::vector<NormalizedError> each;
  std::array<double, 3> coverage = {};  ///< shares of `each`
  /// With their joint covariance; else the sum over `each`, which knows nothing of their
  /// correlations.
  NormalizedError all;
  bool joint = false;
  double Nees() const { return all.squared / all.degrees; }  ///< 1 on average
  /// Where Nees() lies with a probability of 95 % if the covariances are honest. Nothing for
  /// correlated errors without their joint covariance.
  std::optional<std::array<double, 2>> band;
};

/// Errors of six dimensions each, with their covariances; `joint` is the covariance of all of them,
/// one after the other, or empty. Nothing where no error can be normalized.
std::optional<Consistency> MeasureConsistency(const std::vector<Eigen::VectorXd>& errors,
                                              const std::vector<Eigen::MatrixXd>& covariances,
                                              const Eigen::MatrixXd& joint);

}  // namespace planegraph
