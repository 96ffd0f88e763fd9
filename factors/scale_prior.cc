// What is known beforehand of a scale that measurements share, say of the metre of a robot's
// odometry:
//
//   r = (s - s_0) / sigma
//
// without unit; s_0 is the factor's point.x(), 1/sigma^2 the upper left of its information.
#include <ceres/sized_cost_function.h>

#include <cmath>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"

namespace planegraph {
namespace {

class ScalePriorCost final : public ceres::SizedCostFunction<1, 1> {
 public:
  ScalePriorCost(double scale, double information)
      : scale_(scale), weight_(std::sqrt(information)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (blocks[0][0] - scale_);
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = weight_;
    return true;
  }

 private:
  double scale_, weight_;
};

FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  FactorSample sample;
  sample.cost =
      std::make_unique<ScalePriorCost>(sampler.Uniform(0.5, 2.0), sampler.LogUniform(1.0, 1e8));
  sample.kinds = {BlockKind::kScale};
  sample.values = {{sampler.LogUniform(1e-3, 1e3)}};
  return sample;
}

}  // namespace

void Register_scale_prior(FactorRegistry* registry) {
  FactorType type;
  type.name = "scale_prior";
  type.kind = FactorKind::kPose;
  type.description = "prior of a scale that measurements share";
  type.source = "normal prior; own derivation";
  type.residual = "scale against the prior, over its sigma";
  type.parameters = {{"point", "-", "x: the scale as it is expected", 0.0, true},
                     {"information", "-", "upper left: 1 / sigma^2", 0.0, true}};
  type.make_cost = [](const PoseFactor& factor) {
    return std::make_unique<ScalePriorCost>(factor.point.x(), factor.information(0, 0));
  };
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
