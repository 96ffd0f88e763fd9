#include "pose_graph/lifted_graph.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "pose_graph/edge_model.h"

namespace planegraph {

using Eigen::MatrixXd;

template <int Dim>
LiftedGraph<Dim>::LiftedGraph(const PoseGraph<Dim>& graph)
    : graph_(graph),
      blocks_(graph),
      held_(GaugeOf(graph)),
      pattern_(static_cast<int>(graph.poses.size()), PairsOf(graph)) {
  for (const GraphPose<Dim>& pose : graph.poses) {
    MatrixXd x(Dim, Dim + 1);
    x << pose.rotation, pose.translation;
    x_.push_back(x);
  }
}

template <int Dim>
typename LiftedGraph<Dim>::State LiftedGraph<Dim>::Times(const State& x) const {
  State product(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) product[i] = x[i] * blocks_.diagonal[i];
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const GraphEdge<Dim>& edge = graph_.edges[k];
    product[edge.from] += x[edge.to] * blocks_.cross[k].transpose();
    product[edge.to] += x[edge.from] * blocks_.cross[k];
  }
  return product;
}

// As a sum of squares: tr(X M X^T) itself would lose a small F among large terms.
template <int Dim>
double LiftedGraph<Dim>::ObjectiveOf(const State& x) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const GraphEdge<Dim>& edge = graph_.edges[k];
    const double kappa = -blocks_.cross[k]
                              .template topLeftCorner<Dim, Dim>()
                              .cwiseProduct(edge.measurement.rotation)
                              .sum() /
                         Dim;
    const double tau = -blocks_.cross[k](Dim, Dim);
    const MatrixXd &from = x[edge.from], &to = x[edge.to];
    sum +=
        kappa * (to.leftCols(Dim) - from.leftCols(Dim) * edge.measurement.rotation).squaredNorm();
    sum += tau * (to.col(Dim) - from.col(Dim) - from.leftCols(Dim) * edge.measurement.translation)
                     .squaredNorm();
  }
  return sum;
}

// Columns: unit steps of the unknowns as stacked columns of [Y t]: turns within the span of Y,
// moves out of it, then the translation.
template <int Dim>
MatrixXd LiftedGraph<Dim>::TangentBasis(const MatrixXd& x) const {
  const int p = rank_, turns = Dim * (Dim - 1) / 2, out = (p - Dim) * Dim;
  MatrixXd basis = MatrixXd::Zero(p * (Dim + 1), turns + out + p);
  int column = 0;
  for (int a = 0; a < Dim; ++a) {
    for (int b = a + 1; b < Dim; ++b, ++column) {
      basis.block(b * p, column, p, 1) = x.col(a);
      basis.block(a * p, column, p, 1) = -x.col(b);
    }
  }
  if (p > Dim) {
    const MatrixXd q = Eigen::HouseholderQR<MatrixXd>(x.leftCols(Dim)).householderQ();
    for (int a = 0; a < Dim; ++a, column += p - Dim) {
      basis.block(a * p, column, p, p - Dim) = q.rightCols(p - Dim);
    }
  }
  basis.block(Dim * p, column, p, p).setIdentity();
  return basis;
}

// To the nearest matrix with orthonormal columns.
template <int Dim>
void LiftedGraph<Dim>::Retract(MatrixXd* x) {
  const Small gram = x->leftCols(Dim).transpose() * x->leftCols(Dim);
  const Eigen::SelfAdjointEigenSolver<Small> solver(gram);
  x->leftCols(Dim) *=
      Small(solver.eigenvectors() * solver.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal() *
            solver.eigenvectors().transpose());
}

template <int Dim>
typename LiftedGraph<Dim>::State LiftedGraph<Dim>::Moved(const std::vector<MatrixXd>& bases,
                                                         const MatrixXd& step) const {
  State moved = x_;
  const Eigen::Index size = bases.front().cols();
  for (std::size_t i = 0; i < x_.size(); ++i) {
    if (held_[i]) continue;
    const Eigen::VectorXd change = bases[i] * step.middleRows(i * size, size);
    moved[i] += Eigen::Map<const MatrixXd>(change.data(), rank_, Dim + 1);
    Retract(&moved[i]);
  }
  return moved;
}

template <int Dim>
bool LiftedGraph<Dim>::Escape(const MatrixXd& direction) {
  ++rank_;
  for (MatrixXd& x : x_) {
    x.conservativeResize(rank_, Dim + 1);
    x.row(rank_ - 1).setZero();
  }
  const double before = Objective();
  double largest = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    largest = std::max(largest, direction.row(i).template head<Dim>().norm());
  }
  for (double angle = 1.0; angle > 1e-6; angle *= 0.5) {
    State moved = x_;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      moved[i].row(rank_ - 1) += angle / largest * direction.row(i);
      Retract(&moved[i]);
    }
    if (ObjectiveOf(moved) >= before) continue;
    x_ = moved;
    return true;
  }
  return false;
}

template <int Dim>
std::vector<typename LiftedGraph<Dim>::Small> LiftedGraph<Dim>::Multipliers() const {
  const State gradient = Times(x_);
  std::vector<Small> multipliers(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const Small product = x_[i].leftCols(Dim).transpose() * gradient[i].leftCols(Dim);
    multipliers[i] = 0.5 * (product + product.transpose());
  }
  return multipliers;
}

template <int Dim>
void LiftedGraph<Dim>::Assemble(const std::vector<MatrixXd>& bases, bool newton, double damping,
                                BlockCholesky* hessian, MatrixXd* gradient) const {
  const int size = static_cast<int>(bases.front().cols());
  // (block x 1_p) times a basis, for stacked columns.
  const auto times = [this, size](const auto& block, const MatrixXd& basis) {
    MatrixXd product = MatrixXd::Zero(basis.rows(), size);
    for (int a = 0; a <= Dim; ++a) {
      for (int b = 0; b <= Dim; ++b) {
        product.middleRows(a * rank_, rank_) += block(a, b) * basis.middleRows(b * rank_, rank_);
      }
    }
    return product;
  };
  const State slope = Times(x_);
  const std::vector<Small> multipliers = Multipliers();
  hessian->SetZero();
  for (int i = 0; i < static_cast<int>(x_.size()); ++i) {
    auto diagonal = hessian->DiagonalBlock(i);
    if (held_[i]) {
      diagonal.setIdentity();
      gradient->middleRows(i * size, size).setZero();
      continue;
    }
    typename Blocks::Block block = blocks_.diagonal[i];
    if (newton) block.template topLeftCorner<Dim, Dim>() -= multipliers[i];
    diagonal = bases[i].transpose() * times(block, bases[i]);
    const MatrixXd scale = bases[i].transpose() * times(blocks_.diagonal[i], bases[i]);
    diagonal.diagonal() += damping * scale.diagonal();
    gradient->middleRows(i * size, size) =
        bases[i].transpose() * Eigen::Map<const Eigen::VectorXd>(slope[i].data(), slope[i].size());
  }
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const GraphEdge<Dim>& edge = graph_.edges[k];
    if (held_[edge.from] || held_[edge.to]) continue;
    hessian->AddPairBlock(static_cast<int>(k),
                          bases[edge.from].transpose() * times(blocks_.cross[k], bases[edge.to]));
  }
}

template <int Dim>
void LiftedGraph<Dim>::Minimize() {
  constexpr int kMostSteps = 200;
  constexpr double kRest = 1e-9, kTooMuchDamping = 1e9;
  const int size = Dim * (Dim - 1) / 2 + (rank_ - Dim) * Dim + rank_;
  BlockCholesky hessian(pattern_, size);
  MatrixXd gradient(x_.size() * size, 1);
  double cost = Objective(), damping = 1e-3;
  bool newton = true;
  for (int step = 0; step < kMostSteps && damping < kTooMuchDamping; ++step) {
    std::vector<MatrixXd> bases;
    for (const MatrixXd& x : x_) bases.push_back(TangentBasis(x));
    Assemble(bases, newton, damping, &hessian, &gradient);
    if (!hessian.Factorize()) {
      if (!newton) damping *= 10.0;
      newton = false;
      continue;
    }
    const MatrixXd move = -hessian.Solve(gradient);
    // gradient and Hessian are those of F / 2.
    const double promised = -gradient.col(0).dot(move.col(0));
    const State moved = Moved(bases, move);
    const double new_cost = ObjectiveOf(moved);
    if (new_cost > cost) {
      if (promised <= kRest * cost) return;
      damping *= 10.0;
      newton = false;
      continue;
    }
    newton = cost - new_cost > 0.5 * promised;
    x_ = moved;
    cost = new_cost;
    damping *= newton ? 0.1 : 2.0;
    if (promised <= kRest * cost) return;
  }
}

template <int Dim>
std::vector<GraphPose<Dim>> LiftedGraph<Dim>::Rounded() const {
  MatrixXd gram = MatrixXd::Zero(rank_, rank_);
  for (const MatrixXd& x : x_) gram += x.leftCols(Dim) * x.leftCols(Dim).transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(gram);
  MatrixXd principal = solver.eigenvectors().rightCols(Dim).transpose();
  int mirrored = 0;
  for (const MatrixXd& x : x_) mirrored += (principal * x.leftCols(Dim)).determinant() < 0.0;
  if (2 * mirrored > static_cast<int>(x_.size())) principal.row(0) = -principal.row(0).eval();
  std::vector<GraphPose<Dim>> poses(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const MatrixXd low = principal * x_[i];
    poses[i].rotation = NearestRotation<Dim>(Small(low.leftCols(Dim)));
    poses[i].translation = low.col(Dim);
  }
  return poses;
}

template class LiftedGraph<2>;
template class LiftedGraph<3>;

}  // namespace planegraph
