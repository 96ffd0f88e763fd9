// What is known of two landmarks a and b:
//
//   parallel        r = w (n_a x n_b)
//   perpendicular   r = w (n_a . n_b)
//   coplanar        r = [ w (n_a x n_b) ; w_o (n_a . (o_b + e_b n_b - o_a) - e_a) ]
//
// n, e: normal and offset of the plane from its anchor o (world); w = 1 / sigma_angle in 1/rad, w_o
// = 1 / sigma_offset in 1/m. Either sign of the normals will do. Such factors join two planes:
// planes can then not be eliminated one by one, and the solver factorizes all of them.
#include <ceres/cost_function.h>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::RowVector4d;
using Eigen::Vector3d;

enum class Relation { kParallel, kPerpendicular, kCoplanar };

class PlanePairCost final : public ceres::CostFunction {
 public:
  // `between`: from a's anchor to b's.
  PlanePairCost(Relation relation, const PlaneFactor& factor, const Vector3d& between)
      : relation_(relation),
        between_(between),
        weight_(1.0 / factor.sigma_angle),
        offset_weight_(1.0 / factor.sigma_offset) {
    set_num_residuals(relation == Relation::kParallel ? 3 : 4);
    if (relation == Relation::kPerpendicular) set_num_residuals(1);
    *mutable_parameter_block_sizes() = {kPlaneSize, kPlaneSize};
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Vector3d a = Eigen::Map<const Vector3d>(blocks[0]);
    const Vector3d b = Eigen::Map<const Vector3d>(blocks[1]);
    double* by_a = jacobians == nullptr ? nullptr : jacobians[0];
    double* by_b = jacobians == nullptr ? nullptr : jacobians[1];
    if (relation_ == Relation::kPerpendicular) {
      residuals[0] = weight_ * a.dot(b);
      WriteRow(weight_ * b, 0.0, by_a);
      WriteRow(weight_ * a, 0.0, by_b);
      return true;
    }
    Eigen::Map<Vector3d>(residuals, 3) = weight_ * a.cross(b);
    WriteRows(-weight_ * Hat(b), by_a);
    WriteRows(weight_ * Hat(a), by_b);
    if (relation_ == Relation::kParallel) return true;
    const double offset_b = blocks[1][3];
    const Vector3d across = between_ + offset_b * b;
    residuals[3] = offset_weight_ * (a.dot(across) - blocks[0][3]);
    if (by_a != nullptr) WriteRow(offset_weight_ * across, -offset_weight_, by_a + 12);
    if (by_b != nullptr) {
      WriteRow(offset_weight_ * offset_b * a, offset_weight_ * a.dot(b), by_b + 12);
    }
    return true;
  }

 private:
  static void WriteRow(const Vector3d& by_normal, double by_offset, double* row) {
    if (row == nullptr) return;
    Eigen::Map<RowVector4d>(row, 4) << by_normal.transpose(), by_offset;
  }
  static void WriteRows(const Matrix3d& by_normal, double* rows) {
    if (rows == nullptr) return;
    for (int k = 0; k < 3; ++k) WriteRow(by_normal.row(k).transpose(), 0.0, rows + 4 * k);
  }

  Relation relation_;
  Vector3d between_;
  double weight_, offset_weight_;
};

FactorSample Sample(Relation relation, std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const PlaneLandmark a = sampler.Landmark(), b = sampler.Landmark();
  PlaneFactor factor;
  factor.sigma_angle = sampler.LogUniform(1e-4, 1.0);
  factor.sigma_offset = sampler.LogUniform(1e-4, 1.0);
  FactorSample sample;
  sample.cost = std::make_unique<PlanePairCost>(relation, factor, b.anchor - a.anchor);
  sample.kinds = {BlockKind::kPlane, BlockKind::kPlane};
  sample.values = {FactorSampler::Block(a), FactorSampler::Block(b)};
  return sample;
}

void RegisterRelation(Relation relation, const std::string& name, const std::string& residual,
                      FactorRegistry* registry) {
  FactorType type;
  type.name = name;
  type.kind = FactorKind::kPlanePair;
  type.description = "two landmarks are " + name;
  type.source =
      "relations of planes as constraints, as in Pathak, Birk et al. 2010 and in scene "
      "reconstruction (Furukawa et al.: Manhattan-world stereo, CVPR 2009); own form";
  type.residual = residual;
  type.parameters = {{"sigma_angle", "rad", "sigma of the angle", 0.01, true}};
  if (relation == Relation::kCoplanar) {
    type.parameters.push_back({"sigma_offset", "m", "sigma of the offset", 0.01, true});
  }
  type.make_pair_cost = [relation](const Graph& graph, const PlaneFactor& factor) {
    const Vector3d between =
        graph.planes[factor.planes[1]].anchor - graph.planes[factor.planes[0]].anchor;
    return std::make_unique<PlanePairCost>(relation, factor, between);
  };
  type.sample = [relation](std::mt19937_64* rng) { return Sample(relation, rng); };
  registry->Add(std::move(type));
}

}  // namespace

void Register_plane_pairs(FactorRegistry* registry) {
  RegisterRelation(Relation::kParallel, "parallel",
                   "cross product of the normals (world's axes) over sigma_angle", registry);
  RegisterRelation(Relation::kPerpendicular, "perpendicular",
                   "dot product of the normals over sigma_angle", registry);
  RegisterRelation(Relation::kCoplanar, "coplanar",
                   "cross product of the normals (world's axes) over sigma_angle; the second "
                   "plane's foot over the first one (m) over sigma_offset",
                   registry);
}

}  // namespace planegraph
