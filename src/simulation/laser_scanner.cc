#include "planegraph/simulation/laser_scanner.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// One measured return.
struct Return {
  double range;
  int label;
};

void CheckOptions(const ScannerOptions& o) {
  constexpr double kMostRays = 1e8;
  if (o.beams < 1 || o.sweeps < 1 || double(o.beams) * o.sweeps > kMostRays) {
    throw UsageError("a scan needs at least one beam and sweep, and at most 1e8 rays");
  }
  if (!(o.min_range >= 0.0 && o.max_range > o.min_range && std::isfinite(o.max_range))) {
    throw UsageError("the scanner's ranges must obey 0 <= min_range < max_range");
  }
}

Eigen::Vector3d BeamDirection(const ScannerOptions& o, int sweep, int beam) {
  const double step = o.beams > 1 ? o.fan / (o.beams - 1) : 0.0;
  const double a = -0.5 * step * (o.beams - 1) + step * beam;
  const double r = o.roll * sweep / o.sweeps;
  return {std::cos(a), std::sin(a) * std::cos(r), std::sin(a) * std::sin(r)};
}

Eigen::Vector3d Beside(const Eigen::Vector3d& direction, double angle, double azimuth) {
  const Eigen::Vector2d offset = angle * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
  return (direction + TangentBasis(direction) * offset).normalized();
}

class Ranger {
 public:
  Ranger(const RayCaster& caster, const ScannerOptions& options, Random* random)
      : caster_(caster), options_(options), random_(*random) {}

  std::optional<Return> Measure(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const auto hit = caster_.Cast(origin, direction, options_.max_range);
    if (!hit || random_.Chance(options_.DropoutProbability(hit->distance, hit->cosine))) {
      return std::nullopt;
    }
    Return result{hit->distance, hit->label};
    if (options_.mixed_share > 0.0) Mix(origin, direction, &result);
    result.range += options_.RangeSigma(hit->distance, hit->cosine) * random_.Normal();
    if (result.range < options_.min_range || result.range > options_.max_range) return std::nullopt;
    return result;
  }

 private:
  void Mix(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Return* result) {
    const double angle = options_.divergence * std::sqrt(random_.Uniform());
    const double azimuth = random_.Uniform(0.0, 6.283185307179586);
    const auto other = caster_.Cast(origin, Beside(direction, angle, azimuth), options_.max_range);
    // The smear on one surface at grazing incidence is part of the range noise.
    if (!other || (other->label == result->label && result->label != kNotPlanar)) return;
    const double gap = other->distance - result->range;
    if (std::abs(gap) < options_.mixed_min || std::abs(gap) > options_.mixed_max) return;
    if (!random_.Chance(options_.mixed_share)) return;
    *result = {result->range + random_.Uniform() * gap, kNotPlanar};
  }

  const RayCaster& caster_;
  const ScannerOptions& options_;
  Random& random_;
};

}  // namespace

double ScannerOptions::RangeSigma(double range, double cosine) const {
  return noise_constant + noise_linear * range / max_range +
         (cosine < grazing_cosine ? noise_grazing : 0.0);
}

double ScannerOptions::DropoutProbability(double range, double cosine) const {
  const double share = range / max_range;
  const double grazing = cosine < dropout_cosine ? 1.0 - cosine / dropout_cosine : 0.0;
  return dropout_constant + dropout_quadratic * share * share + dropout_grazing * grazing;
}

ScannerOptions ScannerOptions::WithoutNoise() const {
  ScannerOptions ideal = *this;
  ideal.noise_constant = ideal.noise_linear = ideal.noise_grazing = 0.0;
  ideal.dropout_constant = ideal.dropout_quadratic = ideal.dropout_grazing = 0.0;
  ideal.mixed_share = 0.0;
  return ideal;
}

LabelledScan Scan(const RayCaster& caster, const Rigid3& world_from_scan,
                  const ScannerOptions& options, Random* random) {
  CheckOptions(options);
  Ranger ranger(caster, options, random);
  LabelledScan scan;
  for (int sweep = 0; sweep < options.sweeps; ++sweep) {
    for (int beam = 0; beam < options.beams; ++beam) {
      const Eigen::Vector3d direction = BeamDirection(options, sweep, beam);
      const auto hit =
          ranger.Measure(world_from_scan.translation, world_from_scan.rotation * direction);
      if (!hit) continue;
      scan.cloud.points.push_back((hit->range * direction).cast<float>());
      scan.labels.push_back(hit->label);
    }
  }
  return scan;
}

}  // namespace planegraph
