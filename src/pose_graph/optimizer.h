#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "planegraph/pose_graph/optimization.h"
#include "pose_graph/block_cholesky.h"
#include "pose_graph/edge_model.h"
#include "pose_graph/gauge.h"

namespace planegraph {

// Below this the damping is switched off, and above this there is no step left to take.
inline constexpr double kLeastDamping = 1e-12, kMostDamping = 1e12;

// Gauss-Newton serves until a step lowers the cost by less than this fraction: before, its matrix
// is the safer one (it is never indefinite).
inline constexpr double kNear = 1e-2;

// What Gauss-Newton may leave behind, of the tolerance: about the square of it, as Newton does.
inline constexpr double kGaussNewtonRest = 1e-4;

// A gain of cost for each edge that moves nothing by a noticeable part of its sigma (costs are in
// units of sigma squared): edges without contradiction have no cost to take a fraction of.
inline constexpr double kNothing = 1e-16;

/// The minimizer behind OptimizePoseGraph. It keeps the order of elimination from one run to the
/// next, for those who change weights or poses and solve again.
template <int Dim>
class Optimizer {
 public:
  static constexpr int kSize = kPoseDimension<Dim>;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  /// Both have to outlive it; the options may change between runs, all but the loss.
  Optimizer(PoseGraph<Dim>* graph, const PoseGraphOptions* options)
      : graph_(*graph),
        options_(*options),
        loss_(MakeLoss(options->loss)),
        held_(GaugeOf(*graph)),
        pattern_(static_cast<int>(graph->poses.size()), PairsOf(*graph)),
        hessian_(pattern_, kSize),
        gradient_(graph->poses.size() * kSize, 1),
        scale_(graph->poses.size() * kSize, 1) {}

  /// `damping`: of the first step; with that of the last run where the problem has hardly changed.
  PoseGraphSummary Run(double damping = 0.0) {
    PoseGraphSummary summary;
    damping_ = damping;
    growth_ = 2.0;
    near_ = options_.near_minimum;
    last_promised_ = 0.0;
    double cost = CostOf(graph_.poses);
    summary.initial_cost = summary.final_cost = cost;
    while (summary.iterations < options_.max_iterations && !summary.converged) {
      if (!Iterate(&cost, &summary)) break;
      ++summary.iterations;
    }
    summary.final_cost = cost;
    return summary;
  }
  double damping() const { return damping_; }

 private:
  // One step that lowers the cost, or none: false where no damping makes one.
  bool Iterate(double* cost, PoseGraphSummary* summary) {
    bool newton = near_ && !robust();
    while (damping_ <= kMostDamping) {
      Assemble(newton);
      ++summary->factorizations;
      if (!hessian_.Factorize()) {
        if (!newton) Dampen();
        newton = false;
        continue;
      }
      const Eigen::MatrixXd step = -hessian_.Solve(gradient_);
      const double promised = -0.5 * gradient_.col(0).dot(step.col(0));
      const std::vector<GraphPose<Dim>> moved = Moved(step);
      const double new_cost = CostOf(moved);
      const bool rest = Rests(newton, promised, *cost);
      // At rest the change of the cost is lost in its rounding.
      if (new_cost < *cost || (rest && new_cost <= *cost * (1.0 + 1e-12))) {
        last_promised_ = promised;
        Accept(moved, new_cost, (*cost - new_cost) / promised, rest, cost, summary);
        return true;
      }
      if (rest) return summary->converged = true;
      newton = false;
      Dampen();
    }
    return false;
  }

  // Newton's steps square what is left. Gauss-Newton's shrink it at a rate that the last two tell.
  bool Rests(bool newton, double promised, double cost) const {
    if (promised <= kNothing * static_cast<double>(graph_.edges.size())) return true;
    if (newton) return promised <= options_.tolerance * cost;
    const double rate = last_promised_ > 0.0 ? std::min(1.0, promised / last_promised_) : 1.0;
    return promised * rate <= kGaussNewtonRest * options_.tolerance * cost;
  }

  void Accept(const std::vector<GraphPose<Dim>>& moved, double new_cost, double gain, bool rest,
              double* cost, PoseGraphSummary* summary) {
    near_ = gain > 0.5 && *cost - new_cost < kNear * *cost;
    graph_.poses = moved;
    *cost = new_cost;
    summary->converged = rest && damping_ == 0.0;
    // Nielsen's rule (1999): the better the model served, the less damping.
    if (damping_ > 0.0) damping_ *= std::clamp(1.0 - std::pow(2.0 * gain - 1.0, 3), 0.1, 4.0);
    growth_ = 2.0;
    if (damping_ < kLeastDamping) damping_ = 0.0;
  }

  void Dampen() {
    damping_ = std::max(growth_ * damping_, 1e-9);
    growth_ *= 2.0;
  }
  bool robust() const { return loss_ != nullptr; }

  double WeightOf(std::size_t edge) const {
    return options_.weights.empty() ? 1.0 : options_.weights[edge];
  }
  // rho and rho' of an edge.
  std::pair<double, double> Loss(const GraphEdge<Dim>& edge, double chi2) const {
    if (!robust() || !edge.robust) return {chi2, 1.0};
    double rho[3];
    loss_->Evaluate(chi2, rho);
    return {rho[0], rho[1]};
  }

  double CostOf(const std::vector<GraphPose<Dim>>& poses) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      const GraphEdge<Dim>& edge = graph_.edges[k];
      const Vector residual =
          EdgeResidual<Dim>(poses[edge.from], poses[edge.to], edge, graph_.rotation_residual);
      sum += WeightOf(k) * Loss(edge, residual.dot(edge.information * residual)).first;
    }
    return 0.5 * sum;
  }

  void Assemble(bool newton) {
    hessian_.SetZero();
    gradient_.setZero();
    scale_.setZero();
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) AddEdge(k, newton);
    for (std::size_t i = 0; i < graph_.poses.size(); ++i) {
      auto block = hessian_.Diagonal<kSize>(static_cast<int>(i));
      if (held_[i]) {
        block.setIdentity();
        gradient_.middleRows(i * kSize, kSize).setZero();
        continue;
      }
      block.diagonal() += damping_ * scale_.middleRows(i * kSize, kSize);
    }
  }

  void AddEdge(std::size_t k, bool newton) {
    const GraphEdge<Dim>& edge = graph_.edges[k];
    ModelEdge<Dim>(graph_.poses[edge.from], graph_.poses[edge.to], edge, graph_.rotation_residual,
                   newton, &model_);
    const double chi2 = model_.residual.dot(edge.information * model_.residual);
    const double weight = WeightOf(k) * Loss(edge, chi2).second;
    const Matrix information = weight * edge.information;
    const Matrix from = model_.by_from.transpose() * information;
    const Matrix to = model_.by_to.transpose() * information;
    AddPose(edge.from, from * model_.residual, from * model_.by_from,
            newton ? Matrix(weight * model_.curvature_from) : Matrix::Zero());
    AddPose(edge.to, to * model_.residual, to * model_.by_to,
            newton ? Matrix(weight * model_.curvature_to) : Matrix::Zero());
    if (held_[edge.from] || held_[edge.to]) return;
    Matrix cross = from * model_.by_to;
    if (newton) cross += weight * model_.curvature_cross;
    hessian_.AddPair<kSize>(static_cast<int>(k), cross);
  }

  void AddPose(int pose, const Vector& gradient, const Matrix& hessian, const Matrix& curvature) {
    gradient_.middleRows(pose * kSize, kSize) += gradient;
    scale_.middleRows(pose * kSize, kSize) += hessian.diagonal();
    hessian_.Diagonal<kSize>(pose) += hessian + curvature;
  }

  std::vector<GraphPose<Dim>> Moved(const Eigen::MatrixXd& step) const {
    std::vector<GraphPose<Dim>> poses = graph_.poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (!held_[i]) poses[i] = Retract<Dim>(poses[i], Vector(step.middleRows(i * kSize, kSize)));
    }
    return poses;
  }

  PoseGraph<Dim>& graph_;
  const PoseGraphOptions& options_;
  std::unique_ptr<ceres::LossFunction> loss_;
  std::vector<bool> held_;
  BlockPattern pattern_;
  BlockCholesky hessian_;
  Eigen::MatrixXd gradient_, scale_;
  EdgeModel<Dim> model_;
  double damping_ = 0.0, growth_ = 2.0, last_promised_ = 0.0;
  bool near_ = false;  // the last step did what it promised, and little: Newton's turn
};

}  // namespace planegraph
