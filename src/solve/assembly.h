#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <map>
#include <memory>
#include <vector>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/loss.h"
#include "planegraph/graph/manifolds.h"
#include "planegraph/solve/solver.h"

namespace planegraph {

/// One residual block.
struct Residual {
  std::unique_ptr<ceres::CostFunction> cost;
  std::vector<BlockRef> blocks;
  ResidualTag tag;
  double weight = 1.0;
  ceres::LossFunction* loss = nullptr;  ///< with the weight in it; null: squared, weight 1
};

/// Whether the residual is that of a whole plane, which is an unknown within it.
inline bool HidesPlane(const Residual& residual) {
  return residual.tag.plane >= 0 && residual.tag.observation < 0;
}

/// Residuals that a graduated loss weighs as one.
struct SwitchGroup {
  const LossSpec* loss = nullptr;
  std::vector<int> residuals;         ///< indices in Assembly::residuals()
  std::vector<WeightLoss*> switches;  ///< of each
};

/// A residual block with its Jacobians in the tangent spaces. Both are scaled by the square root of
/// weight * rho', so that J^T J is the (first-order) information and J^T r the gradient.
struct LinearizedResidual {
  Eigen::VectorXd residual;
  std::vector<Eigen::MatrixXd>
      jacobians;  ///< residuals x 6 (pose), x 3 (plane), x 7 (map), x 1 (scale)
  /// 2 rho'' |r|^2 / rho': what a robust loss takes from the second derivative of the cost along
  /// the residual, relative to that of the squared one; 0 or less.
  double radial_curvature = 0.0;
};

/// All residuals of a graph, and the parameter blocks they work on. Ceres and the covariance both
/// read from it. The graph has to live as long.
class Assembly final : public ResidualSink {
 public:
  Assembly(const Graph& graph, const SolveOptions& options);

  void Add(std::unique_ptr<ceres::CostFunction> cost, std::vector<BlockRef> blocks,
           const ResidualTag& tag, double weight) override;

  const std::vector<Residual>& residuals() const { return residuals_; }
  const std::vector<SwitchGroup>& switch_groups() const { return switch_groups_; }
  bool plane_blocks() const { return plane_blocks_; }
  double* Block(const BlockRef& block);
  double* PoseBlock(int index) { return &poses_[std::size_t(kPoseSize) * index]; }
  double* PlaneBlock(int index) { return &planes_[std::size_t(kPlaneSize) * index]; }
  double* MapBlock(int index) { return &maps_[std::size_t(kMapSize) * index]; }
  double* ScaleBlock(int index) { return &scales_[std::size_t(index)]; }

  /// |r|^2 of a residual, and its weight times rho' in *weight, at the present values.
  double Chi2(const Residual& residual, double* weight);
  /// Evaluates and converts to tangent space at the present values.
  void Linearize(const Residual& residual, LinearizedResidual* out);
  /// Writes the blocks' values back into the graph.
  void Store(Graph* graph) const;

 private:
  void SetBlocks(const Graph& graph);
  void AddPlanes(const Graph& graph, const SolveOptions& options);
  void AddPlaneFactors(const Graph& graph);
  void AddMapFactors(const Graph& graph);
  // What the residuals that are added next take: nothing, a function, or a graduated loss.
  struct PresentLoss {
    const ceres::LossFunction* function = nullptr;
    const LossSpec* graduated = nullptr;
  };
  PresentLoss LossOf(const std::string& type, const LossSpec& general, bool robust);
  void AddPoseFactors(const Graph& graph);
  ceres::LossFunction* LossFor(double weight);
  void AddSwitch(Residual* residual);
  int GroupOf(const ResidualTag& tag) const;

  const Graph& graph_;
  std::vector<double> poses_, planes_, maps_, scales_;
  std::vector<Residual> residuals_;
  bool plane_blocks_ = false;
  PresentLoss present_;
  const LossSpec plane_loss_, pose_loss_;
  const std::map<std::string, LossSpec> factor_losses_;
  std::map<const LossSpec*, const ceres::LossFunction*> functions_;
  std::vector<SwitchGroup> switch_groups_;
  std::map<std::pair<const LossSpec*, std::pair<bool, int>>, std::size_t> group_places_;
  std::vector<std::unique_ptr<ceres::LossFunction>> losses_;
  std::map<std::pair<const ceres::LossFunction*, double>, ceres::LossFunction*> scaled_losses_;
};

/// What the gauge holds.
struct Gauge {
  std::vector<bool> poses, maps, scales;  ///< scales: none is held
};
/// Poses and maps that are fixed; the first pose where nothing is, and (unless `count_priors` is
/// false) no prior holds the graph either. Without priors, maps that had one are held.
Gauge GaugeFixed(const Graph& graph, bool count_priors);

}  // namespace planegraph
