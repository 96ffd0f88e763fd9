#include "solve/selected_inverse.h"

#include <utility>

namespace planegraph {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// Of a column of L, the inverse of its diagonal block, and of the pivot that it is the root of.
struct Pivot {
  MatrixXd root_inverse, inverse;
};

Pivot PivotOf(const MatrixXd& values) {
  const Index size = values.cols();
  Pivot pivot;
  pivot.root_inverse =
      values.topRows(size).triangularView<Eigen::Lower>().solve(MatrixXd::Identity(size, size));
  pivot.inverse = pivot.root_inverse.transpose() * pivot.root_inverse;
  return pivot;
}

}  // namespace

SelectedInverse::SelectedInverse(const BlockFactor& factor) : columns_(factor.columns()) {
  for (int column = columns_.count() - 1; column >= 0; --column) Invert(column);
}

void SelectedInverse::Invert(int column) {
  MatrixXd& values = columns_.Values(column);
  const Index size = values.cols(), rest = values.rows() - size;
  const Pivot pivot = PivotOf(values);
  const MatrixXd reach = values.bottomRows(rest) * pivot.root_inverse;
  values.bottomRows(rest).noalias() = -columns_.Below(column) * reach;
  values.topRows(size) = pivot.inverse - reach.transpose() * values.bottomRows(rest);
}

SelectedSandwich::SelectedSandwich(const BlockFactor& factor,
                                   const Eigen::SparseMatrix<double>& scatter,
                                   const SelectedInverse& inverse)
    : columns_(factor.columns()) {
  columns_.Set(scatter);
  for (int column = 0; column < columns_.count(); ++column) Eliminate(factor.columns(), column);
  for (int column = columns_.count() - 1; column >= 0; --column) {
    Invert(factor.columns(), inverse.columns(), column);
  }
}

// A column with pivot d and b below it leaves C - b d^-1 b^T; with K = b d^-1 the derivative of
// that is C' - b' K^T - K b'^T + K d' K^T.
void SelectedSandwich::Eliminate(const BlockColumns& lower, int column) {
  const MatrixXd& factor = lower.Values(column);
  const Index size = factor.cols(), rest = factor.rows() - size;
  if (rest == 0) return;
  const MatrixXd reach = factor.bottomRows(rest) * PivotOf(factor).root_inverse;
  const MatrixXd& values = columns_.Values(column);
  const MatrixXd pivot = values.topRows(size).selfadjointView<Eigen::Lower>();
  const MatrixXd half = values.bottomRows(rest) - 0.5 * reach * pivot;
  const MatrixXd product = half * reach.transpose();
  columns_.AddBelow(column, -product - product.transpose());
}

// The inverse Z has -Z_below K below the diagonal and d^-1 - K^T (that) on it.
void SelectedSandwich::Invert(const BlockColumns& lower, const BlockColumns& inverse, int column) {
  const MatrixXd& factor = lower.Values(column);
  const Index size = factor.cols(), rest = factor.rows() - size;
  const Pivot pivot = PivotOf(factor);
  const MatrixXd reach = factor.bottomRows(rest) * pivot.root_inverse;
  MatrixXd& values = columns_.Values(column);
  const MatrixXd changed = values.topRows(size).selfadjointView<Eigen::Lower>();
  const MatrixXd changed_reach = (values.bottomRows(rest) - reach * changed) * pivot.inverse;
  values.bottomRows(rest) = -columns_.Below(column) * reach - inverse.Below(column) * changed_reach;
  values.topRows(size) = -pivot.inverse * changed * pivot.inverse -
                         changed_reach.transpose() * inverse.Values(column).bottomRows(rest) -
                         reach.transpose() * values.bottomRows(rest);
}

}  // namespace planegraph
