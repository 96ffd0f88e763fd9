#include "pose_graph/block_cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace planegraph {
namespace {

// CHOLMOD opens a parallel region for every supernode; for the small ones of a pose graph waking
// the threads takes longer than the work (measured on sphere2500: half of the time). One thread
// also adds up in one order. The OpenMP runtime is CHOLMOD's, not ours: it is asked for by name,
// and where there is none nothing is to be done.
class OneThread {
 public:
  OneThread() {
    if (Get() == nullptr || Set() == nullptr) return;
    levels_ = Get()();
    Set()(0);
  }
  ~OneThread() {
    if (levels_ >= 0) Set()(levels_);
  }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  using Getter = int (*)();
  using Setter = void (*)(int);
  static Getter Get() {
    static const auto get =
        reinterpret_cast<Getter>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
    return get;
  }
  static Setter Set() {
    static const auto set =
        reinterpret_cast<Setter>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
    return set;
  }

  int levels_ = -1;
};

// A CHOLMOD workspace that prints nothing.
class Workspace {
 public:
  Workspace() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.error_handler = nullptr;
  }
  ~Workspace() { cholmod_finish(&common_); }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  cholmod_common* get() { return &common_; }

 private:
  cholmod_common common_{};
};

cholmod_sparse* Allocate(int rows, std::size_t count, int type, cholmod_common* common) {
  cholmod_sparse* matrix = cholmod_allocate_sparse(rows, rows, count, 1, 1, -1, type, common);
  if (matrix == nullptr) throw std::bad_alloc();
  return matrix;
}

// Neighbours with larger index, sorted, each once.
std::vector<std::vector<int>> LowerColumns(int size, const std::vector<std::pair<int, int>>& pairs,
                                           const std::vector<int>& position) {
  std::vector<std::vector<int>> columns(size);
  for (int i = 0; i < size; ++i) columns[i].push_back(i);
  for (const auto& [a, b] : pairs) {
    const auto [low, high] = std::minmax(position[a], position[b]);
    columns[low].push_back(high);
  }
  for (std::vector<int>& column : columns) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
  }
  return columns;
}

void FillPattern(const std::vector<std::vector<int>>& columns, cholmod_sparse* matrix) {
  int* starts = static_cast<int*>(matrix->p);
  int* rows = static_cast<int*>(matrix->i);
  starts[0] = 0;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    std::copy(columns[c].begin(), columns[c].end(), rows + starts[c]);
    starts[c + 1] = starts[c] + static_cast<int>(columns[c].size());
  }
}

// Row at each place of the elimination: the better of AMD and METIS' nested dissection.
std::vector<int> EliminationOrder(const std::vector<std::vector<int>>& columns) {
  Workspace workspace;
  cholmod_common* common = workspace.get();
  common->nmethods = 2;
  common->method[0].ordering = CHOLMOD_AMD;
  common->method[1].ordering = CHOLMOD_METIS;
  const int size = static_cast<int>(columns.size());
  std::size_t count = 0;
  for (const std::vector<int>& column : columns) count += column.size();
  cholmod_sparse* matrix = Allocate(size, count, CHOLMOD_PATTERN, common);
  FillPattern(columns, matrix);
  cholmod_factor* factor = cholmod_analyze(matrix, common);
  cholmod_free_sparse(&matrix, common);
  if (factor == nullptr) throw std::bad_alloc();
  const int* permutation = static_cast<const int*>(factor->Perm);
  std::vector<int> order(permutation, permutation + size);
  cholmod_free_factor(&factor, common);
  return order;
}

cholmod_dense View(const Eigen::MatrixXd& matrix) {
  cholmod_dense view{};
  view.nrow = view.d = matrix.rows();
  view.ncol = matrix.cols();
  view.nzmax = matrix.size();
  view.x = const_cast<double*>(matrix.data());
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

}  // namespace

BlockPattern::BlockPattern(int size, const std::vector<std::pair<int, int>>& pairs)
    : position_(size) {
  std::iota(position_.begin(), position_.end(), 0);
  const std::vector<int> order = EliminationOrder(LowerColumns(size, pairs, position_));
  for (int place = 0; place < size; ++place) position_[order[place]] = place;
  columns_ = LowerColumns(size, pairs, position_);
  pair_slots_.reserve(pairs.size());
  for (const auto& [a, b] : pairs) {
    const auto [low, high] = std::minmax(position_[a], position_[b]);
    const std::vector<int>& column = columns_[low];
    const auto found = std::lower_bound(column.begin(), column.end(), high);
    pair_slots_.push_back({low, static_cast<int>(found - column.begin()), position_[a] == low});
  }
}

struct BlockCholesky::Impl {
  Workspace workspace;
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;

  cholmod_common* common() { return workspace.get(); }
  ~Impl() {
    if (factor != nullptr) cholmod_free_factor(&factor, common());
    if (matrix != nullptr) cholmod_free_sparse(&matrix, common());
  }
};

BlockCholesky::BlockCholesky(const BlockPattern& pattern, int block_size)
    : pattern_(pattern), block_size_(block_size), impl_(std::make_unique<Impl>()) {
  const int size = pattern.size();
  offsets_.resize(size + 1, 0);
  for (int c = 0; c < size; ++c) {
    offsets_[c + 1] = offsets_[c] + pattern.column(c).size() * block_size * block_size;
  }
  if (offsets_[size] > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw std::length_error("the pose graph is too large for this solver");
  }
  cholmod_common* common = impl_->common();
  impl_->matrix = Allocate(size * block_size, offsets_[size], CHOLMOD_REAL, common);
  int* starts = static_cast<int*>(impl_->matrix->p);
  int* rows = static_cast<int*>(impl_->matrix->i);
  int at = 0, scalar_column = 0;
  for (int c = 0; c < size; ++c) {
    for (int k = 0; k < block_size; ++k) {
      starts[scalar_column++] = at;
      for (const int row : pattern.column(c)) {
        for (int l = 0; l < block_size; ++l) rows[at++] = row * block_size + l;
      }
    }
  }
  starts[scalar_column] = at;
  values_ = static_cast<double*>(impl_->matrix->x);
  SetZero();
  common->nmethods = 1;
  common->method[0].ordering = CHOLMOD_NATURAL;
  common->postorder = 0;  // the pattern's order is a postorder already
  // Supernodes where they pay; chains, as of a planar path, are faster without.
  common->supernodal = CHOLMOD_AUTO;
  common->final_ll = 1;  // L L^T in both cases: it fails where the matrix is not positive definite
  impl_->factor = cholmod_analyze(impl_->matrix, common);
  if (impl_->factor == nullptr) throw std::bad_alloc();
}

BlockCholesky::~BlockCholesky() = default;

void BlockCholesky::SetZero() { std::fill(values_, values_ + offsets_.back(), 0.0); }

BlockCholesky::Block BlockCholesky::BlockAt(int column, int index) {
  const int height = static_cast<int>(pattern_.column(column).size()) * block_size_;
  return {values_ + offsets_[column] + index * block_size_, block_size_, block_size_,
          Eigen::OuterStride<>(height)};
}

void BlockCholesky::AddPairBlock(int pair, const Eigen::MatrixXd& block) {
  const BlockPattern::Slot& slot = pattern_.slot(pair);
  if (slot.first_is_column) {
    BlockAt(slot.column, slot.index) += block.transpose();
  } else {
    BlockAt(slot.column, slot.index) += block;
  }
}

bool BlockCholesky::Factorize() {
  const OneThread one_thread;
  cholmod_common* common = impl_->common();
  const bool done = cholmod_factorize(impl_->matrix, impl_->factor, common) != 0;
  return done && common->status == CHOLMOD_OK && impl_->factor->minor == impl_->factor->n;
}

Eigen::MatrixXd BlockCholesky::Solve(const Eigen::MatrixXd& b) const {
  Eigen::MatrixXd permuted(b.rows(), b.cols());
  for (int row = 0; row < pattern_.size(); ++row) {
    permuted.middleRows(pattern_.position(row) * block_size_, block_size_) =
        b.middleRows(row * block_size_, block_size_);
  }
  const OneThread one_thread;
  cholmod_dense right = View(permuted);
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, impl_->factor, &right, impl_->common());
  if (solution == nullptr) throw std::bad_alloc();
  permuted = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), b.rows(),
                                               b.cols());
  cholmod_free_dense(&solution, impl_->common());
  Eigen::MatrixXd x(b.rows(), b.cols());
  for (int row = 0; row < pattern_.size(); ++row) {
    x.middleRows(row * block_size_, block_size_) =
        permuted.middleRows(pattern_.position(row) * block_size_, block_size_);
  }
  return x;
}

}  // namespace planegraph
