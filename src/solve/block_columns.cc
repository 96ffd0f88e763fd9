#include "solve/block_columns.h"

#include <algorithm>
#include <utility>

namespace planegraph {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// Rows of a column's own nodes: wider ones make the dense products no faster.
constexpr int kMostWidth = 96;

// The nodes below each one in the factor: those of the matrix and what its children hand on.
std::vector<std::vector<int>> Eliminate(std::vector<std::vector<int>> below) {
  std::vector<std::vector<int>> children(below.size());
  for (std::size_t node = 0; node < below.size(); ++node) {
    std::vector<int>& rows = below[node];
    for (const int child : children[node]) {
      rows.insert(rows.end(), below[child].begin() + 1, below[child].end());
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    if (!rows.empty()) children[rows.front()].push_back(static_cast<int>(node));
  }
  return below;
}

}  // namespace

FactorStructure::FactorStructure(std::vector<int> node_rows, std::vector<std::vector<int>> below)
    : first_row(std::move(node_rows)) {
  const std::vector<std::vector<int>> factor = Eliminate(std::move(below));
  const int nodes = static_cast<int>(factor.size());
  for (int node = 0, last = 0; node < nodes; node = last + 1) {
    last = node;
    while (last + 1 < nodes && !factor[last].empty() && factor[last].front() == last + 1 &&
           factor[last].size() == factor[last + 1].size() + 1 &&
           first_row[last + 2] - first_row[node] <= kMostWidth) {
      ++last;
    }
    column_of.insert(column_of.end(), last + 1 - node, static_cast<int>(rows.size()));
    rows.push_back({node});
    rows.back().insert(rows.back().end(), factor[node].begin(), factor[node].end());
  }
}

BlockColumns::BlockColumns(const FactorStructure& structure) : structure_(structure) {
  for (int column = 0; column < static_cast<int>(structure.rows.size()); ++column) {
    starts_.emplace_back(1, 0);
    for (const int node : structure.rows[column]) {
      starts_.back().push_back(starts_.back().back() + Size(node));
    }
    values_.push_back(MatrixXd::Zero(starts_.back().back(), starts_.back()[OwnNodes(column)]));
  }
}

std::size_t BlockColumns::OwnNodes(int column) const {
  const std::vector<int>& rows = structure_.rows[column];
  std::size_t own = 0;
  while (own < rows.size() && ColumnOf(rows[own]) == column) ++own;
  return own;
}

void BlockColumns::Set(const Eigen::SparseMatrix<double>& lower) {
  for (MatrixXd& values : values_) values.setZero();
  std::vector<int> node_of(static_cast<std::size_t>(structure_.first_row.back()));
  for (int node = 0; node + 1 < static_cast<int>(structure_.first_row.size()); ++node) {
    std::fill(node_of.begin() + structure_.first_row[node],
              node_of.begin() + structure_.first_row[node + 1], node);
  }
  for (int j = 0; j < lower.outerSize(); ++j) {
    const int column = ColumnOf(node_of[j]);
    int node = -1, start = 0;
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
      if (node != node_of[it.row()]) node = node_of[it.row()], start = Find(node, column);
      values_[column](start + it.row() - structure_.first_row[node], j - FirstRow(column)) =
          it.value();
    }
  }
}

int BlockColumns::Find(int row, int column) const {
  const std::vector<int>& rows = structure_.rows[column];
  const auto found = std::lower_bound(rows.begin(), rows.end(), row);
  if (found == rows.end() || *found != row) return -1;
  return starts_[column][static_cast<std::size_t>(found - rows.begin())];
}

NodeBlock BlockColumns::Block(int row, int column) const {
  if (row < column) return Block(column, row).transpose();
  const int in = ColumnOf(column);
  return values_[in].block(Find(row, in), Offset(column), Size(row), Size(column));
}

// function(place and start of two nodes below the column's own, first >= second, and where their
// block lies: column, row and column in its values).
template <typename Function>
void BlockColumns::ForEachBelow(int column, const Function& function) const {
  const std::vector<int>& rows = structure_.rows[column];
  const std::vector<int>& starts = starts_[column];
  const std::size_t first = OwnNodes(column);
  for (std::size_t b = first; b < rows.size(); ++b) {
    const int in = ColumnOf(rows[b]), offset = Offset(rows[b]);
    const std::vector<int>& own = structure_.rows[in];
    std::size_t at = 0;
    for (std::size_t a = b; a < rows.size(); ++a) {
      while (own[at] != rows[a]) ++at;
      function(starts[a] - starts[first], starts[b] - starts[first], Size(rows[a]), Size(rows[b]),
               in, starts_[in][at], offset);
    }
  }
}

MatrixXd BlockColumns::Below(int column) const {
  const Index rest = values_[column].rows() - Width(column);
  MatrixXd below(rest, rest);
  ForEachBelow(column, [&](int row, int col, int rows, int cols, int in, int from, int offset) {
    const auto block = values_[in].block(from, offset, rows, cols);
    below.block(row, col, rows, cols) = block;
    below.block(col, row, cols, rows) = block.transpose();
  });
  return below;
}

void BlockColumns::AddBelow(int column, const MatrixXd& below) {
  ForEachBelow(column, [&](int row, int col, int rows, int cols, int in, int from, int offset) {
    values_[in].block(from, offset, rows, cols) += below.block(row, col, rows, cols);
  });
}

MatrixXd BlockColumns::GatherBelow(int column, const MatrixXd& all) const {
  const Index width = Width(column);
  MatrixXd below(values_[column].rows() - width, all.cols());
  for (std::size_t k = OwnNodes(column); k < structure_.rows[column].size(); ++k) {
    const int node = structure_.rows[column][k];
    below.middleRows(starts_[column][k] - width, Size(node)) =
        all.middleRows(structure_.first_row[node], Size(node));
  }
  return below;
}

void BlockColumns::SubtractBelow(int column, const MatrixXd& below, MatrixXd* all) const {
  const Index width = Width(column);
  for (std::size_t k = OwnNodes(column); k < structure_.rows[column].size(); ++k) {
    const int node = structure_.rows[column][k];
    all->middleRows(structure_.first_row[node], Size(node)) -=
        below.middleRows(starts_[column][k] - width, Size(node));
  }
}

}  // namespace planegraph
