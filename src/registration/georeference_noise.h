#pragma once

#include <vector>

#include "registration/georeference_fit.h"

namespace planegraph {

/// A least-squares similarity with a covariance that knows of correlated noise.
struct CorrelatedFit {
  Sim3 world_from_map;
  Matrix7d covariance = Matrix7d::Zero();  ///< as in Georeference
  double sigma_horizontal = 0.0, sigma_vertical = 0.0;
  double inflation = 1.0;
  double time_correction = 0.0, sigma_time = 0.0;  ///< seconds; zero unless asked for
};

struct CorrelationOptions {
  NoisePrior prior;
  bool in_seconds = false;  ///< the pairs' times are seconds, else places in an order
  bool with_time = false;   ///< a shift of all times is a parameter, too
  bool correlated = true;   ///< false: the noise is taken to be white
};

/// Least squares from `start` over inliers in the order of the flight, the two horizontal axes
/// weighted against the vertical one by their noise. The covariance takes the noise of each axis as
/// white in a share 1 - a and as a Gauss-Markov process of the time T in the share a, the same for
/// all axes. a, T and the ratio of vertical to horizontal noise are not chosen but averaged over,
/// by their restricted likelihood (Patterson and Thompson 1971): a short flight tells them badly,
/// and residuals hide what the fit has taken up. Needs three pairs.
CorrelatedFit FitCorrelated(const std::vector<PositionPair>& pairs, const Sim3& start,
                            const CorrelationOptions& options);

}  // namespace planegraph
