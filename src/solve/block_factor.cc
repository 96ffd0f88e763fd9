#include "solve/block_factor.h"

#include <Eigen/Cholesky>

namespace planegraph {

using Eigen::Index;
using Eigen::MatrixXd;

bool BlockFactor::Factorize(const Eigen::SparseMatrix<double>& lower) {
  columns_.Set(lower);
  for (int column = 0; column < columns_.count(); ++column) {
    MatrixXd& values = columns_.Values(column);
    const Index width = columns_.Width(column), rest = values.rows() - width;
    Eigen::Ref<MatrixXd> own = values.topRows(width);
    if (Eigen::LLT<Eigen::Ref<MatrixXd>>(own).info() != Eigen::Success) return false;
    if (rest == 0) continue;
    own.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(
        values.bottomRows(rest));
    MatrixXd product = MatrixXd::Zero(rest, rest);
    product.selfadjointView<Eigen::Lower>().rankUpdate(values.bottomRows(rest), -1.0);
    columns_.AddBelow(column, product);
  }
  return true;
}

MatrixXd BlockFactor::Solve(MatrixXd x) const {
  for (int column = 0; column < columns_.count(); ++column) {
    const MatrixXd& values = columns_.Values(column);
    const Index width = columns_.Width(column);
    auto own = x.middleRows(columns_.FirstRow(column), width);
    values.topRows(width).triangularView<Eigen::Lower>().solveInPlace(own);
    columns_.SubtractBelow(column, values.bottomRows(values.rows() - width) * own, &x);
  }
  for (int column = columns_.count() - 1; column >= 0; --column) {
    const MatrixXd& values = columns_.Values(column);
    const Index width = columns_.Width(column);
    auto own = x.middleRows(columns_.FirstRow(column), width);
    own -= values.bottomRows(values.rows() - width).transpose() * columns_.GatherBelow(column, x);
    values.topRows(width).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
  return x;
}

}  // namespace planegraph
