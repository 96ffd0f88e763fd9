#include "solve/assembly.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/graph/factor_losses.h"

namespace planegraph {
namespace {

// rho' of a loss that carries the weight; 1 without a loss.
double LossDerivative(const ceres::LossFunction* loss, double squared_norm) {
  if (loss == nullptr) return 1.0;
  double rho[3];
  loss->Evaluate(squared_norm, rho);
  return rho[1];
}

// 2 rho'' s / rho', which a loss's scale and weight do not change.
double RadialCurvature(const ceres::LossFunction* loss, double squared_norm) {
  if (loss == nullptr) return 0.0;
  double rho[3];
  loss->Evaluate(squared_norm, rho);
  return rho[1] > 0.0 ? std::min(0.0, 2.0 * rho[2] * squared_norm / rho[1]) : 0.0;
}

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::MatrixXd ToTangent(BlockKind kind, const double* block, const RowMajorMatrix& ambient) {
  if (kind == BlockKind::kPose) {
    Eigen::Matrix<double, kPoseSize, kPoseTangent, Eigen::RowMajor> plus;
    Se3Manifold().PlusJacobian(block, plus.data());
    return ambient * plus;
  }
  if (kind == BlockKind::kMap) {
    Eigen::Matrix<double, kMapSize, kMapTangent, Eigen::RowMajor> plus;
    Sim3Manifold().PlusJacobian(block, plus.data());
    return ambient * plus;
  }
  if (kind == BlockKind::kScale) return ambient;
  Eigen::Matrix<double, kPlaneSize, kPlaneTangent, Eigen::RowMajor> plus;
  PlaneManifold().PlusJacobian(block, plus.data());
  return ambient * plus;
}

}  // namespace

Assembly::Assembly(const Graph& graph, const SolveOptions& options)
    : graph_(graph),
      plane_loss_(options.plane_loss),
      pose_loss_(options.pose_loss),
      factor_losses_(options.factor_losses) {
  CheckFactorNames(factor_losses_, BuiltinFactors());
  SetBlocks(graph);
  AddPlanes(graph, options);
  AddPoseFactors(graph);
}

void Assembly::SetBlocks(const Graph& graph) {
  poses_.resize(graph.poses.size() * kPoseSize);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    PoseToBlock(graph.poses[i].world_from_node, PoseBlock(static_cast<int>(i)));
  }
  planes_.resize(graph.planes.size() * kPlaneSize);
  for (std::size_t k = 0; k < graph.planes.size(); ++k) {
    double* block = PlaneBlock(static_cast<int>(k));
    Eigen::Map<Eigen::Vector3d>(block, 3) = graph.planes[k].normal.normalized();
    block[3] = graph.planes[k].offset;
  }
  maps_.resize(graph.maps.size() * kMapSize);
  for (std::size_t m = 0; m < graph.maps.size(); ++m) {
    MapToBlock(graph.maps[m].world_from_map, MapBlock(static_cast<int>(m)));
  }
  for (const ScaleNode& node : graph.scales) scales_.push_back(node.scale);
}

void Assembly::AddPlanes(const Graph& graph, const SolveOptions& options) {
  const FactorType& type = BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);
  type.CheckOptions(options.plane_factor_options);
  plane_blocks_ = type.plane_blocks;
  std::size_t observations = 0;
  for (const PlaneLandmark& plane : graph.planes) observations += plane.observations.size();
  residuals_.reserve(observations + graph.pose_factors.size());
  present_ = LossOf(type.name, plane_loss_, true);
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    type.add_plane(graph, k, options.plane_factor_options, this);
  }
  AddPlaneFactors(graph);
  const FactorType* in_maps =
      graph.maps.empty() ? nullptr : BuiltinFactors().MapPlaneFactorFor(type);
  if (in_maps == nullptr) return;
  present_ = LossOf(in_maps->name, plane_loss_, true);
  for (int k = 0; k < static_cast<int>(graph.planes.size()); ++k) {
    in_maps->add_plane(graph, k, options.plane_factor_options, this);
  }
}

void Assembly::AddPlaneFactors(const Graph& graph) {
  if (!graph.plane_factors.empty() && !plane_blocks_) {
    throw UsageError("what ties planes needs a plane factor whose planes are unknowns");
  }
  for (int k = 0; k < static_cast<int>(graph.plane_factors.size()); ++k) {
    const PlaneFactor& factor = graph.plane_factors[k];
    const FactorType& type = BuiltinFactors().Get(factor.type, FactorKind::kPlanePair);
    present_ = LossOf(type.name, plane_loss_, factor.robust);
    Add(type.make_pair_cost(graph, factor),
        {{BlockKind::kPlane, factor.planes[0]}, {BlockKind::kPlane, factor.planes[1]}},
        ResidualTag{.plane_factor = k}, 1.0);
  }
}

// The loss of a type's factors, of which each has one function.
Assembly::PresentLoss Assembly::LossOf(const std::string& type, const LossSpec& general,
                                       bool robust) {
  if (!robust) return {};
  const auto own = factor_losses_.find(type);
  const LossSpec* loss = own == factor_losses_.end() ? &general : &own->second;
  if (IsGraduated(*loss)) return {nullptr, loss};
  const auto [place, is_new] = functions_.try_emplace(loss, nullptr);
  if (is_new) {
    losses_.push_back(MakeLoss(*loss));
    place->second = losses_.back().get();
  }
  return {place->second, nullptr};
}

void Assembly::AddMapFactors(const Graph& graph) {
  for (int k = 0; k < static_cast<int>(graph.map_factors.size()); ++k) {
    const MapFactor& factor = graph.map_factors[k];
    const FactorType& type = BuiltinFactors().Get(factor.type, FactorKind::kMap);
    present_ = LossOf(type.name, pose_loss_, factor.robust);
    const ResidualTag tag{.map_factor = k};
    std::vector<BlockRef> blocks;
    for (const int map : factor.maps) blocks.push_back({BlockKind::kMap, map});
    Add(type.make_map_cost(factor), std::move(blocks), tag, 1.0);
  }
}

void Assembly::AddPoseFactors(const Graph& graph) {
  for (int k = 0; k < static_cast<int>(graph.pose_factors.size()); ++k) {
    const PoseFactor& factor = graph.pose_factors[k];
    const FactorType& type = BuiltinFactors().Get(factor.type, FactorKind::kPose);
    present_ = LossOf(type.name, pose_loss_, factor.robust);
    const ResidualTag tag{.pose_factor = k};
    std::vector<BlockRef> blocks;
    for (const int pose : factor.poses) blocks.push_back({BlockKind::kPose, pose});
    if (factor.scale >= 0) blocks.push_back({BlockKind::kScale, factor.scale});
    Add(type.make_cost(factor), std::move(blocks), tag, 1.0);
  }
  AddMapFactors(graph);
}

void Assembly::Add(std::unique_ptr<ceres::CostFunction> cost, std::vector<BlockRef> blocks,
                   const ResidualTag& tag, double weight) {
  Residual& residual = residuals_.emplace_back();
  residual.cost = std::move(cost);
  residual.blocks = std::move(blocks);
  residual.tag = tag;
  residual.weight = weight;
  if (present_.graduated == nullptr) {
    residual.loss = LossFor(weight);
  } else {
    AddSwitch(&residual);
  }
}

// What the caller says of an observation or a pose factor; -1: it is by itself.
int Assembly::GroupOf(const ResidualTag& tag) const {
  if (tag.plane >= 0 && tag.observation >= 0) {
    const auto& observations = graph_.planes[tag.plane].observations;
    const int group = observations[tag.observation].group;
    return group < 0 && tag.other_observation >= 0 ? observations[tag.other_observation].group
                                                   : group;
  }
  return tag.pose_factor >= 0 ? graph_.pose_factors[tag.pose_factor].group : -1;
}

void Assembly::AddSwitch(Residual* residual) {
  auto weight = std::make_unique<WeightLoss>(residual->weight);
  const int group = GroupOf(residual->tag);
  std::size_t place = switch_groups_.size();
  if (group >= 0) {
    const std::pair key(present_.graduated, std::pair(residual->tag.plane >= 0, group));
    place = group_places_.try_emplace(key, place).first->second;
  }
  if (place == switch_groups_.size()) switch_groups_.push_back({present_.graduated, {}, {}});
  switch_groups_[place].residuals.push_back(static_cast<int>(residuals_.size()) - 1);
  switch_groups_[place].switches.push_back(weight.get());
  residual->loss = weight.get();
  losses_.push_back(std::move(weight));
}

// One loss object per kernel and weight: the weights 2/k take few values.
ceres::LossFunction* Assembly::LossFor(double weight) {
  if (present_.function == nullptr && weight == 1.0) return nullptr;
  ceres::LossFunction*& loss = scaled_losses_[{present_.function, weight}];
  if (loss == nullptr) {
    losses_.push_back(std::make_unique<ceres::ScaledLoss>(present_.function, weight,
                                                          ceres::DO_NOT_TAKE_OWNERSHIP));
    loss = losses_.back().get();
  }
  return loss;
}

double* Assembly::Block(const BlockRef& block) {
  if (block.kind == BlockKind::kMap) return MapBlock(block.index);
  if (block.kind == BlockKind::kScale) return ScaleBlock(block.index);
  return block.kind == BlockKind::kPose ? PoseBlock(block.index) : PlaneBlock(block.index);
}

double Assembly::Chi2(const Residual& residual, double* weight) {
  Eigen::VectorXd r(residual.cost->num_residuals());
  std::vector<const double*> blocks;
  for (const BlockRef& block : residual.blocks) blocks.push_back(Block(block));
  residual.cost->Evaluate(blocks.data(), r.data(), nullptr);
  const double chi2 = r.squaredNorm();
  if (weight != nullptr) *weight = LossDerivative(residual.loss, chi2);
  return chi2;
}

void Assembly::Linearize(const Residual& residual, LinearizedResidual* out) {
  const int rows = residual.cost->num_residuals();
  out->residual.resize(rows);
  const std::size_t count = residual.blocks.size();
  std::vector<RowMajorMatrix> ambient(count);
  std::vector<const double*> blocks(count);
  std::vector<double*> jacobians(count);
  for (std::size_t k = 0; k < count; ++k) {
    ambient[k].resize(rows, residual.cost->parameter_block_sizes()[k]);
    blocks[k] = Block(residual.blocks[k]);
    jacobians[k] = ambient[k].data();
  }
  residual.cost->Evaluate(blocks.data(), out->residual.data(), jacobians.data());
  const double squared_norm = out->residual.squaredNorm();
  out->radial_curvature = RadialCurvature(residual.loss, squared_norm);
  const double scale = std::sqrt(LossDerivative(residual.loss, squared_norm));
  out->residual *= scale;
  out->jacobians.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    out->jacobians[k] = scale * ToTangent(residual.blocks[k].kind, blocks[k], ambient[k]);
  }
}

void Assembly::Store(Graph* graph) const {
  for (std::size_t i = 0; i < graph->poses.size(); ++i) {
    graph->poses[i].world_from_node = PoseFromBlock(&poses_[kPoseSize * i]);
  }
  for (std::size_t k = 0; k < graph->planes.size(); ++k) {
    const double* block = &planes_[kPlaneSize * k];
    graph->planes[k].normal = Eigen::Map<const Eigen::Vector3d>(block).normalized();
    graph->planes[k].offset = block[3];
  }
  for (std::size_t m = 0; m < graph->maps.size(); ++m) {
    graph->maps[m].world_from_map = MapFromBlock(&maps_[kMapSize * m]);
  }
  for (std::size_t s = 0; s < graph->scales.size(); ++s) graph->scales[s].scale = scales_[s];
}

Gauge GaugeFixed(const Graph& graph, bool count_priors) {
  Gauge gauge;
  for (const PoseNode& node : graph.poses) gauge.poses.push_back(node.fixed);
  for (const MapNode& node : graph.maps) gauge.maps.push_back(node.fixed);
  gauge.scales.assign(graph.scales.size(), false);
  bool has_prior = false;
  for (const MapFactor& factor : graph.map_factors) {
    if (factor.maps.size() != 1) continue;
    has_prior = true;
    if (!count_priors) gauge.maps[factor.maps[0]] = true;
  }
  const auto held = [](const std::vector<bool>& fixed) {
    return std::find(fixed.begin(), fixed.end(), true) != fixed.end();
  };
  if (gauge.poses.empty() || held(gauge.poses) || held(gauge.maps)) return gauge;
  const auto prior =
      std::find_if(graph.pose_factors.begin(), graph.pose_factors.end(),
                   [](const PoseFactor& factor) { return factor.poses.size() == 1; });
  const bool has_pose_prior = prior != graph.pose_factors.end();
  if (!has_pose_prior && !has_prior) gauge.poses[0] = true;
  if (has_pose_prior && !count_priors) gauge.poses[prior->poses[0]] = true;
  return gauge;
}

}  // namespace planegraph
