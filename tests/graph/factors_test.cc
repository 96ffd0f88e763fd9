// What holds for every registered factor, known only through its sample().
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <limits>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

const ceres::Manifold& ManifoldOf(BlockKind kind) {
  static const Se3Manifold pose;
  static const PlaneManifold plane;
  static const Sim3Manifold map;
  static const ceres::EuclideanManifold<1> scale;
  if (kind == BlockKind::kPose) return pose;
  if (kind == BlockKind::kMap) return map;
  if (kind == BlockKind::kScale) return scale;
  return plane;
}

VectorXd Evaluate(const FactorSample& sample, std::size_t block, const VectorXd& delta) {
  std::vector<std::vector<double>> values = sample.values;
  ManifoldOf(sample.kinds[block])
      .Plus(sample.values[block].data(), delta.data(), values[block].data());
  std::vector<const double*> pointers;
  for (const auto& value : values) pointers.push_back(value.data());
  VectorXd residual(sample.cost->num_residuals());
  EXPECT_TRUE(sample.cost->Evaluate(pointers.data(), residual.data(), nullptr));
  return residual;
}

// Whether a tangent's column is a length, and where the lengths of a block's values begin and end.
bool IsLength(BlockKind kind, int column) {
  if (kind == BlockKind::kScale) return false;
  return kind == BlockKind::kPlane ? column == 2 : column < 3;
}
std::pair<std::size_t, std::size_t> Lengths(BlockKind kind) {
  if (kind == BlockKind::kPlane) return {3, 4};
  if (kind == BlockKind::kScale) return {0, 0};
  return {4, 7};
}

// Ridders' method: central differences over shrinking steps, extrapolated to zero; the best of the
// table by its own estimate of the error. So no cost has to say over what angle or length it bends.
VectorXd Derivative(const std::function<VectorXd(double)>& f, double step) {
  constexpr int kSteps = 12;
  constexpr double kShrink = 2.5;
  std::vector<VectorXd> previous, row;
  VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSteps; ++i, step /= kShrink) {
    row = {(f(step) - f(-step)) / (2.0 * step)};
    double power = 1.0;
    for (int j = 1; j <= i; ++j) {
      power *= kShrink * kShrink;
      row.push_back((power * row[j - 1] - previous[j - 1]) / (power - 1.0));
      const double error =
          std::max((row[j] - row[j - 1]).norm(), (row[j] - previous[j - 1]).norm());
      if (error < least) least = error, best = row[j];
    }
    previous = row;
  }
  return best;
}

MatrixXd NumericJacobian(const FactorSample& sample, std::size_t block, double length) {
  const int size = ManifoldOf(sample.kinds[block]).TangentSize();
  MatrixXd jacobian(sample.cost->num_residuals(), size);
  for (int k = 0; k < size; ++k) {
    const double step = IsLength(sample.kinds[block], k) ? 0.1 * length : 0.1;
    jacobian.col(k) = Derivative(
        [&](double h) { return Evaluate(sample, block, h * VectorXd::Unit(size, k)); }, step);
  }
  return jacobian;
}

MatrixXd AnalyticJacobian(const FactorSample& sample, std::size_t block) {
  const ceres::Manifold& manifold = ManifoldOf(sample.kinds[block]);
  RowMajorMatrix ambient(sample.cost->num_residuals(), manifold.AmbientSize());
  std::vector<const double*> pointers;
  for (const auto& value : sample.values) pointers.push_back(value.data());
  std::vector<double*> jacobians(sample.values.size(), nullptr);
  jacobians[block] = ambient.data();
  VectorXd residual(sample.cost->num_residuals());
  EXPECT_TRUE(sample.cost->Evaluate(pointers.data(), residual.data(), jacobians.data()));
  RowMajorMatrix plus(manifold.AmbientSize(), manifold.TangentSize());
  manifold.PlusJacobian(sample.values[block].data(), plus.data());
  return ambient * plus;
}

double LengthOf(const FactorSample& sample) {
  double length = 1e-3;
  for (std::size_t block = 0; block < sample.kinds.size(); ++block) {
    const auto& value = sample.values[block];
    const auto [first, last] = Lengths(sample.kinds[block]);
    for (std::size_t k = first; k < last; ++k) {
      length = std::max(length, std::abs(value[k]));
    }
  }
  return length;
}

// Largest error, relative to the size of its row (angles and lengths apart, as their units differ)
// and to what double precision leaves of a residual of that size.
double JacobianError(const FactorSample& sample) {
  const double length = LengthOf(sample);
  double largest = 0.0;
  for (std::size_t block = 0; block < sample.values.size(); ++block) {
    const MatrixXd numeric = NumericJacobian(sample, block, length);
    const MatrixXd analytic = AnalyticJacobian(sample, block);
    const VectorXd residual =
        Evaluate(sample, block, VectorXd::Zero(ManifoldOf(sample.kinds[block]).TangentSize()));
    for (int column = 0; column < analytic.cols(); ++column) {
      const bool is_length = IsLength(sample.kinds[block], column);
      const double unit = is_length ? length : 1.0;
      const double size = analytic.col(column).norm() * unit + analytic.norm() * 1e-3 * unit +
                          residual.norm() * 1e-3;
      const double error = (numeric - analytic).col(column).norm() * unit;
      if (size > 0.0) largest = std::max(largest, error / size);
    }
  }
  return largest;
}

class EveryFactor : public testing::TestWithParam<std::string> {
 protected:
  const FactorType& type() const { return BuiltinFactors().types().at(GetParam()); }
};

TEST_P(EveryFactor, JacobiansAreTheDerivatives) {
  std::mt19937_64 rng(7);
  for (int trial = 0; trial < 2000; ++trial) {
    const FactorSample sample = type().sample(&rng);
    ASSERT_LT(JacobianError(sample), 1e-6) << "trial " << trial;
  }
}

TEST_P(EveryFactor, SaysWhatItIs) {
  EXPECT_EQ(type().name, GetParam());
  EXPECT_FALSE(type().description.empty());
  EXPECT_FALSE(type().residual.empty());
  EXPECT_EQ(type().description.find('\n'), std::string::npos);
  EXPECT_FALSE(type().source.empty());
  EXPECT_EQ(type().source.find('\n'), std::string::npos);
  for (const FactorParameter& parameter : type().parameters) EXPECT_FALSE(parameter.unit.empty());
  const FactorKind kind = type().kind;
  EXPECT_EQ(static_cast<bool>(type().add_plane),
            kind == FactorKind::kPlane || kind == FactorKind::kMapPlane);
  EXPECT_EQ(static_cast<bool>(type().make_cost), kind == FactorKind::kPose);
  EXPECT_EQ(static_cast<bool>(type().make_pair_cost), kind == FactorKind::kPlanePair);
  EXPECT_EQ(static_cast<bool>(type().make_map_cost), kind == FactorKind::kMap);
}

std::vector<std::string> AllNames() {
  std::vector<std::string> names;
  for (const auto& [name, type] : BuiltinFactors().types()) names.push_back(name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(Factors, EveryFactor, testing::ValuesIn(AllNames()),
                         [](const auto& test) { return test.param; });

// A cost whose Jacobian is wrong in one number by one in 10^4.
class WrongJacobian final : public ceres::CostFunction {
 public:
  explicit WrongJacobian(std::unique_ptr<ceres::CostFunction> right) : right_(std::move(right)) {
    set_num_residuals(right_->num_residuals());
    *mutable_parameter_block_sizes() = right_->parameter_block_sizes();
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const bool done = right_->Evaluate(blocks, residuals, jacobians);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      const int last = num_residuals() * kPoseSize - 1;
      jacobians[0][last] *= 1.0 + 1e-4;
    }
    return done;
  }

 private:
  std::unique_ptr<ceres::CostFunction> right_;
};

TEST(JacobianTest, FindsAWrongJacobian) {
  std::mt19937_64 rng(7);
  int found = 0;
  for (int trial = 0; trial < 100; ++trial) {
    FactorSample sample = BuiltinFactors().types().at("pose_prior").sample(&rng);
    sample.cost = std::make_unique<WrongJacobian>(std::move(sample.cost));
    found += JacobianError(sample) > 1e-6;
  }
  EXPECT_GT(found, 50);  // half of the samples have a last row of zeros
}

// Collects the cost functions that a factor makes.
class Collector final : public ResidualSink {
 public:
  void Add(std::unique_ptr<ceres::CostFunction> cost, std::vector<BlockRef>, const ResidualTag&,
           double weight) override {
    costs.push_back(std::move(cost));
    weights.push_back(weight);
  }
  std::vector<std::unique_ptr<ceres::CostFunction>> costs;
  std::vector<double> weights;
};

TEST(PlaneMoments, CostIsTheSumOverAllPointsWithoutTheThickness) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    FactorSampler sampler(&rng);
    const double sigma = 0.02;
    Moments moments;
    std::vector<Eigen::Vector3d> points;
    const Rigid3 patch(sampler.Rotation(), {3, -2, 5});
    for (int k = 0; k < 200; ++k) {
      points.push_back(patch * Eigen::Vector3d(sampler.Uniform(-2, 2), sampler.Uniform(-1, 1),
                                               sampler.Uniform(-0.03, 0.03)));
      moments.Add(points.back());
    }
    const PrincipalAxes axes = ComputePrincipalAxes(moments.scatter);
    Graph graph;
    graph.poses = {{"a", Rigid3(sampler.Rotation(), {10, 20, 30})}};
    PlaneLandmark plane;
    plane.anchor = graph.poses[0].world_from_node * moments.mean + 0.1 * sampler.UnitVector();
    plane.normal = sampler.UnitVector();
    plane.offset = sampler.Uniform(-1, 1);
    PlaneObservation seen;
    seen.centroid = moments.mean;
    seen.axes = axes.vectors;
    seen.tilt_weight_1 = std::sqrt(axes.values[1]) / sigma;
    seen.tilt_weight_2 = std::sqrt(axes.values[2]) / sigma;
    seen.offset_weight = std::sqrt(moments.count) / sigma;
    plane.observations = {seen};
    graph.planes = {plane};

    Collector collector;
    BuiltinFactors().Get("moments", FactorKind::kPlane).add_plane(graph, 0, {}, &collector);
    ASSERT_EQ(collector.costs.size(), 1u);
    const auto pose = FactorSampler::Block(graph.poses[0].world_from_node);
    const auto block = FactorSampler::Block(plane);
    const double* blocks[2] = {pose.data(), block.data()};
    Eigen::Vector3d residual;
    collector.costs[0]->Evaluate(blocks, residual.data(), nullptr);

    double sum = 0.0;
    for (const auto& point : points) {
      const double distance =
          plane.WorldPlane().SignedDistance(graph.poses[0].world_from_node * point);
      sum += distance * distance / (sigma * sigma);
    }
    const Eigen::Vector3d normal =
        graph.poses[0].world_from_node.rotation.conjugate() * plane.normal;
    const double thickness =
        axes.values[0] / (sigma * sigma) * std::pow(axes.vectors.col(0).dot(normal), 2);
    EXPECT_NEAR((residual.squaredNorm() + thickness) / sum, 1.0, 1e-9);
  }
}

TEST(PlanePosePose, PairsOfAPlaneSeenKTimesWeighTwoOverK) {
  std::mt19937_64 rng(3);
  FactorSampler sampler(&rng);
  Graph graph;
  PlaneLandmark plane = sampler.Landmark();
  for (int i = 0; i < 5; ++i) {
    graph.poses.push_back({"", sampler.Pose()});
    plane.observations.push_back(sampler.Observation(i));
  }
  graph.planes = {plane};
  Collector collector;
  BuiltinFactors().Get("pose_pose", FactorKind::kPlane).add_plane(graph, 0, {}, &collector);
  ASSERT_EQ(collector.costs.size(), 10u);
  for (const double weight : collector.weights) EXPECT_DOUBLE_EQ(weight, 0.4);
}

TEST(FactorRegistry, ParsesNamesWithOptions) {
  const FactorRegistry& all = BuiltinFactors();
  EXPECT_TRUE(all.Parse("moments", FactorKind::kPlane).options.empty());
  const FactorChoice choice = all.Parse("unit_quaternion:unit_length=2.5", FactorKind::kPlane);
  EXPECT_EQ(choice.name, "unit_quaternion");
  EXPECT_EQ(choice.options, (FactorOptions{{"unit_length", 2.5}}));
  for (const char* text : {"", "nothing", "unit_quaternion:unit_length",
                           "unit_quaternion:unit_length=", "unit_quaternion:unit_length=x",
                           "unit_quaternion:unit_length=inf", "unit_quaternion:unit_length=0",
                           "unit_quaternion:unit_length=-1", "moments:unit_length=1", "parallel"}) {
    EXPECT_THROW(all.Parse(text, FactorKind::kPlane), UsageError) << text;
  }
}

TEST(FactorRegistry, EveryPlaneFactorKnowsItsCounterpartForMaps) {
  for (const auto& [name, type] : BuiltinFactors().types()) {
    if (type.kind != FactorKind::kPlane) continue;
    const FactorType* in_maps = BuiltinFactors().MapPlaneFactorFor(type);
    if (in_maps == nullptr) continue;
    EXPECT_EQ(in_maps->plane_blocks, type.plane_blocks) << name;
  }
}

TEST(FactorRegistry, NamesAreUniqueAndKindsAreKept) {
  FactorRegistry registry;
  FactorType type;
  type.name = "x";
  registry.Add(type);
  EXPECT_THROW(registry.Add(type), std::invalid_argument);
  EXPECT_NO_THROW(registry.Get("x", FactorKind::kPlane));
  EXPECT_THROW(registry.Get("x", FactorKind::kPose), UsageError);
  EXPECT_THROW(registry.Get("y", FactorKind::kPlane), UsageError);
}

}  // namespace
}  // namespace planegraph
