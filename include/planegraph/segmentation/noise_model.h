#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// Noise of a single laser point: along the beam it is constant + per_metre * range (metres); along
/// the surface's normal its share by the cosine of the incidence angle remains, and to it comes
/// what the surfaces themselves deviate from planes.
struct NoiseModel {
  double constant = 0.01;
  double per_metre = 0.0;
  /// Least share that is left at grazing incidence, where the beam's footprint takes over.
  static constexpr double kLeastCosine = 0.25;

  double AlongBeam(double range) const { return constant + per_metre * range; }
  /// Plaster, concrete and paving are not flat to better than some millimetres.
  static constexpr double kSurface = 0.003;
  double AlongNormal(double range, double cosine) const {
    return std::hypot(AlongBeam(range) * std::max(std::abs(cosine), kLeastCosine), kSurface);
  }
};

/// The scatter of one small neighbourhood about its plane, as a sample for EstimateNoise.
struct NoiseSample {
  double range = 0.0;     ///< metres from the sensor
  double variance = 0.0;  ///< squared distance to the fitted plane per degree of freedom, m^2,
                          ///< divided by the squared cosine of incidence
};

/// The noise model that explains the flat ones among the samples: in bins of equal sample count
/// over the range the mode of log(variance) is taken (half-sample mode, Bickel and Fruehwirth 2006;
/// the cells that hold edges or clutter only make the upper tail longer), and a line with
/// non-negative coefficients is fitted through the bins. With fewer than 30 samples: the default
/// model.
NoiseModel EstimateNoise(std::vector<NoiseSample> samples);

}  // namespace planegraph
