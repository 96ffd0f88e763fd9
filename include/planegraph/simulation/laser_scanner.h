#pragma once

#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/geometry/rigid3.h"
#include "planegraph/simulation/random.h"
#include "planegraph/simulation/ray_caster.h"

namespace planegraph {

/// A rolling 2-D laser scanner: a fan of beams in a plane that holds the x axis and is turned about
/// it. Beam b of sweep s has the direction (cos a, sin a cos r, sin a sin r) in the scanner's frame
/// (x forward, y left, z up), with a over the fan and r over the roll. The cone behind the scanner
/// that the fan leaves out stays blind.
struct ScannerOptions {
  int beams = 541;                 ///< per sweep
  int sweeps = 180;                ///< positions of the fan
  double fan = 4.71238898038469;   ///< opening of the fan, radians (270 degrees)
  double roll = 3.14159265358979;  ///< range of the turning, radians
  double min_range = 0.3;          ///< shorter returns are dropped, metres
  double max_range = 35.0;         ///< metres

  /// Range noise: sigma = constant + linear * r / max_range (+ grazing below grazing_cosine),
  /// metres.
  double noise_constant = 0.01, noise_linear = 0.01, noise_grazing = 0.01;
  double grazing_cosine = 0.3;  ///< of the incidence angle

  /// Probability that a return is lost: constant + quadratic * (r / max_range)^2 + grazing * (1 - c
  /// / dropout_cosine) where the cosine c of the incidence is below dropout_cosine.
  double dropout_constant = 0.008, dropout_quadratic = 0.05, dropout_grazing = 0.5;
  double dropout_cosine = 0.15;

  /// Mixed pixels: where a second ray within `divergence` (radians) meets another surface between
  /// mixed_min and mixed_max (metres) nearer or farther, in a share of mixed_share a blend of both
  /// ranges is returned.
  double divergence = 0.0035, mixed_min = 0.12, mixed_max = 4.0, mixed_share = 0.6;

  double RangeSigma(double range, double cosine) const;
  double DropoutProbability(double range, double cosine) const;
  /// The same rays without noise, drop-outs and mixed pixels.
  ScannerOptions WithoutNoise() const;
};

/// A scan and the truth about its points.
struct LabelledScan {
  Cloud cloud;              ///< scanner frame, in the order of sweeps and beams
  std::vector<int> labels;  ///< per point: the plane, or kNotPlanar
};

/// Scans from where the scanner stands. Throws UsageError for options that make no sense.
LabelledScan Scan(const RayCaster& caster, const Rigid3& world_from_scan,
                  const ScannerOptions& options, Random* random);

}  // namespace planegraph
