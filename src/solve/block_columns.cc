#include "solve/block_columns.h"

#include <algorithm>
#include <utility>

namespace planegraph {

using Eigen::Index;
using Eigen::MatrixXd;

BlockColumns::BlockColumns(const Eigen::SparseMatrix<double>& lower, std::vector<int> first_row)
    : first_row_(std::move(first_row)), block_of_(static_cast<std::size_t>(first_row_.back())) {
  const int blocks = static_cast<int>(first_row_.size()) - 1;
  for (int b = 0; b < blocks; ++b) {
    std::fill(block_of_.begin() + first_row_[b], block_of_.begin() + first_row_[b + 1], b);
  }
  rows_.resize(blocks), starts_.resize(blocks), values_.resize(blocks);
  for (int b = 0; b < blocks; ++b) SetRows(lower, b);
  Set(lower);
}

void BlockColumns::Set(const Eigen::SparseMatrix<double>& lower) {
  for (int b = 0; b < count(); ++b) {
    values_[b].setZero();
    for (int j = first_row_[b]; j < first_row_[b + 1]; ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
        const int row = block_of_[it.row()];
        values_[b](Find(row, b) + it.row() - first_row_[row], j - first_row_[b]) = it.value();
      }
    }
  }
}

void BlockColumns::SetRows(const Eigen::SparseMatrix<double>& lower, int column) {
  std::vector<int>& rows = rows_[column];
  rows.push_back(column);
  for (int j = first_row_[column]; j < first_row_[column + 1]; ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
      if (rows.back() != block_of_[it.row()]) rows.push_back(block_of_[it.row()]);
    }
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  starts_[column].push_back(0);
  for (const int row : rows) starts_[column].push_back(starts_[column].back() + Size(row));
  values_[column] = MatrixXd::Zero(starts_[column].back(), Size(column));
}

int BlockColumns::Find(int row, int column) const {
  const std::vector<int>& rows = rows_[column];
  const auto found = std::lower_bound(rows.begin(), rows.end(), row);
  if (found == rows.end() || *found != row) return -1;
  return starts_[column][static_cast<std::size_t>(found - rows.begin())];
}

MatrixXd BlockColumns::Block(int row, int column) const {
  if (row < column) return Block(column, row).transpose();
  return values_[column].middleRows(Find(row, column), Size(row));
}

MatrixXd BlockColumns::Below(int column) const {
  const std::vector<int>&rows = rows_[column], &starts = starts_[column];
  const int top = starts[1];
  MatrixXd below(starts.back() - top, starts.back() - top);
  for (std::size_t b = 1; b < rows.size(); ++b) {
    const MatrixXd& values = values_[rows[b]];
    const std::vector<int>& own = rows_[rows[b]];
    std::size_t at = 0;
    for (std::size_t a = b; a < rows.size(); ++a) {
      while (own[at] != rows[a]) ++at;
      const auto block = values.middleRows(starts_[rows[b]][at], Size(rows[a]));
      below.block(starts[a] - top, starts[b] - top, block.rows(), block.cols()) = block;
      below.block(starts[b] - top, starts[a] - top, block.cols(), block.rows()) = block.transpose();
    }
  }
  return below;
}

void BlockColumns::AddBelow(int column, const MatrixXd& below) {
  const std::vector<int>&rows = rows_[column], &starts = starts_[column];
  const int top = starts[1];
  for (std::size_t b = 1; b < rows.size(); ++b) {
    const std::vector<int>& own = rows_[rows[b]];
    std::size_t at = 0;
    for (std::size_t a = b; a < rows.size(); ++a) {
      while (own[at] != rows[a]) ++at;
      values_[rows[b]].middleRows(starts_[rows[b]][at], Size(rows[a])) +=
          below.block(starts[a] - top, starts[b] - top, Size(rows[a]), Size(rows[b]));
    }
  }
}

}  // namespace planegraph
