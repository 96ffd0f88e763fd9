#include "planegraph/pose_graph/certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "pose_graph/block_cholesky.h"
#include "pose_graph/gauge.h"

namespace planegraph {
namespace {

using Eigen::MatrixXd;

template <int Dim>
IsotropicWeights<Dim> WeightsIn(const GraphEdge<Dim>& edge) {
  const int last = kPoseDimension<Dim> - 1;
  const IsotropicWeights<Dim> weights{edge.information(0, 0), edge.information(last, last) / 8.0};
  const PoseInformation<Dim> difference = edge.information - IsotropicInformation<Dim>(weights);
  if (!(difference.norm() <= 1e-12 * edge.information.norm())) {
    throw std::invalid_argument("the certificate needs isotropic weights");
  }
  return weights;
}

// The dual matrix S = M - Lambda over blocks (rotation, translation) of each pose, the translation
// of one pose in each part of the graph left out (it changes nothing).
template <int Dim>
class DualMatrix {
 public:
  static constexpr int kBlock = Dim + 1;
  using Block = Eigen::Matrix<double, kBlock, kBlock>;

  explicit DualMatrix(const PoseGraph<Dim>& graph)
      : graph_(graph),
        held_(GaugeOf(graph)),
        pattern_(static_cast<int>(graph.poses.size()), PairsOf(graph)),
        matrix_(pattern_, kBlock) {
    for (const GraphEdge<Dim>& edge : graph.edges) weights_.push_back(WeightsIn<Dim>(edge));
    ComputeLambda();
  }

  double objective() const { return objective_; }
  double largest() const { return largest_; }
  const BlockCholesky& matrix() const { return matrix_; }

  // S + eta on the rotations: positive definite?
  bool IsPositive(double eta) {
    Assemble(eta);
    return matrix_.Factorize();
  }
  // S + eta again, after IsPositive(eta) was true.
  MatrixXd Solve(const MatrixXd& b) const { return matrix_.Solve(b); }

  // S times b, of which the left-out translations are zero.
  MatrixXd Multiply(const MatrixXd& b) {
    Assemble(0.0);
    return matrix_.Multiply(b);
  }
  bool IsLeftOut(int row) const { return row % kBlock == Dim && held_[row / kBlock]; }

 private:
  Block FromBlock(const GraphEdge<Dim>& edge, const IsotropicWeights<Dim>& w) const {
    Block block;
    const auto& z = edge.measurement.translation;
    block.template topLeftCorner<Dim, Dim>() =
        w.kappa * Eigen::Matrix<double, Dim, Dim>::Identity() + w.tau * z * z.transpose();
    block.template topRightCorner<Dim, 1>() = w.tau * z;
    block.template bottomLeftCorner<1, Dim>() = w.tau * z.transpose();
    block(Dim, Dim) = w.tau;
    return block;
  }
  Block CrossBlock(const GraphEdge<Dim>& edge, const IsotropicWeights<Dim>& w) const {
    Block block = Block::Zero();
    block.template topLeftCorner<Dim, Dim>() = -w.kappa * edge.measurement.rotation;
    block.template topRightCorner<Dim, 1>() = -w.tau * edge.measurement.translation;
    block(Dim, Dim) = -w.tau;
    return block;
  }

  void ComputeLambda() {
    lambda_.assign(graph_.poses.size(), Eigen::Matrix<double, Dim, Dim>::Zero());
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      const GraphEdge<Dim>& edge = graph_.edges[k];
      const GraphPose<Dim>&from = graph_.poses[edge.from], &to = graph_.poses[edge.to];
      const auto& [tau, kappa] = weights_[k];
      const Eigen::Matrix<double, Dim, Dim> turn =
          to.rotation - from.rotation * edge.measurement.rotation;
      const Eigen::Matrix<double, Dim, 1> shift =
          to.translation - from.translation - from.rotation * edge.measurement.translation;
      // Half the gradient of F by each rotation, taken to its node's axes.
      lambda_[edge.from] -=
          kappa * from.rotation.transpose() * turn * edge.measurement.rotation.transpose() +
          tau * (from.rotation.transpose() * shift) * edge.measurement.translation.transpose();
      lambda_[edge.to] += kappa * to.rotation.transpose() * turn;
      objective_ += kappa * turn.squaredNorm() + tau * shift.squaredNorm();
    }
    for (auto& block : lambda_) block = (0.5 * (block + block.transpose())).eval();
  }

  void Assemble(double eta) {
    matrix_.SetZero();
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      const GraphEdge<Dim>& edge = graph_.edges[k];
      const IsotropicWeights<Dim>& w = weights_[k];
      matrix_.template Diagonal<kBlock>(edge.from) += FromBlock(edge, w);
      auto to = matrix_.template Diagonal<kBlock>(edge.to);
      to.diagonal().template head<Dim>().array() += w.kappa;
      to(Dim, Dim) += w.tau;
      Block cross = CrossBlock(edge, w);
      if (held_[edge.from]) cross.row(Dim).setZero();
      if (held_[edge.to]) cross.col(Dim).setZero();
      matrix_.template AddPair<kBlock>(static_cast<int>(k), cross);
    }
    for (int i = 0; i < static_cast<int>(lambda_.size()); ++i) FinishDiagonal(i, eta);
  }

  void FinishDiagonal(int pose, double eta) {
    auto block = matrix_.template Diagonal<kBlock>(pose);
    largest_ = std::max(largest_, block.template topLeftCorner<Dim, Dim>().trace());
    block.template topLeftCorner<Dim, Dim>() -= lambda_[pose];
    block.diagonal().template head<Dim>().array() += eta;
    if (!held_[pose]) return;
    block.row(Dim).setZero();
    block.col(Dim).setZero();
    block(Dim, Dim) = 1.0;
  }

  const PoseGraph<Dim>& graph_;
  std::vector<bool> held_;
  BlockPattern pattern_;
  BlockCholesky matrix_;
  std::vector<IsotropicWeights<Dim>> weights_;
  std::vector<Eigen::Matrix<double, Dim, Dim>> lambda_;
  double objective_ = 0.0, largest_ = 0.0;
};

}  // namespace

template <int Dim>
Certificate Certify(const PoseGraph<Dim>& graph) {
  CheckIndices(graph);
  if (graph.rotation_residual != RotationResidual::kHalfSine ||
      std::count(graph.fixed.begin(), graph.fixed.end(), true) > 1) {
    throw std::invalid_argument("the certificate needs one free gauge and half-sine residuals");
  }
  DualMatrix<Dim> dual(graph);
  Certificate certificate;
  certificate.objective = dual.objective();
  const double rows = Dim * static_cast<double>(graph.poses.size());
  for (double gap = 1e-9; gap <= 1e3; gap *= 10.0) {
    const double eta = gap * dual.objective() / rows;
    const bool ok = dual.IsPositive(eta);
    if (!ok) continue;
    certificate.suboptimality_bound = gap * dual.objective();
    certificate.certified = gap <= kCertifiedGap;
    break;
  }
  return certificate;
}

template Certificate Certify<2>(const PoseGraph2&);
template Certificate Certify<3>(const PoseGraph3&);

}  // namespace planegraph
