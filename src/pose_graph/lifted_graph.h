#pragma once

#include <vector>

#include "pose_graph/block_cholesky.h"
#include "pose_graph/connection_blocks.h"
#include "pose_graph/gauge.h"

namespace planegraph {

/// The isotropic problem with rotations lifted to p x Dim matrices with orthonormal columns and
/// translations to R^p, p >= Dim (the Burer-Monteiro factorization of SE-Sync's semidefinite
/// relaxation; Boumal's Riemannian staircase raises p).
template <int Dim>
class LiftedGraph {
 public:
  using Blocks = ConnectionBlocks<Dim>;
  using Small = Eigen::Matrix<double, Dim, Dim>;

  /// Of rank Dim, at the graph's poses. The graph has to outlive it.
  explicit LiftedGraph(const PoseGraph<Dim>& graph);

  int rank() const { return rank_; }
  double Objective() const { return ObjectiveOf(x_); }
  /// Raises the rank by one and moves along `direction` (Certificate::direction) as far as lowers
  /// F. False where no step does.
  bool Escape(const Eigen::MatrixXd& direction);
  /// To a stationary point.
  void Minimize();
  /// The dual multipliers of the orthonormality.
  std::vector<Small> Multipliers() const;
  /// The nearest poses: principal Dim-dimensional subspace, projected to rotations.
  std::vector<GraphPose<Dim>> Rounded() const;

  const Blocks& blocks() const { return blocks_; }
  const BlockPattern& pattern() const { return pattern_; }
  const std::vector<bool>& held() const { return held_; }

 private:
  using State = std::vector<Eigen::MatrixXd>;  // [Y_i t_i] of each pose, rank x (Dim + 1)

  State Times(const State& x) const;  // X M
  double ObjectiveOf(const State& x) const;
  Eigen::MatrixXd TangentBasis(const Eigen::MatrixXd& x) const;
  State Moved(const std::vector<Eigen::MatrixXd>& bases, const Eigen::MatrixXd& step) const;
  static void Retract(Eigen::MatrixXd* x);
  void Assemble(const std::vector<Eigen::MatrixXd>& bases, bool newton, double damping,
                BlockCholesky* hessian, Eigen::MatrixXd* gradient) const;

  const PoseGraph<Dim>& graph_;
  Blocks blocks_;
  std::vector<bool> held_;
  BlockPattern pattern_;
  int rank_ = Dim;
  State x_;
};

}  // namespace planegraph
