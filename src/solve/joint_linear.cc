#include "solve/joint_linear.h"

#include <Eigen/SparseCholesky>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Pulls towards where things are, relative to the mean of the diagonal: far below what any plane
// says, and enough where none says anything.
constexpr double kStay = 1e-8;

// Normal equations in blocks of the unknowns of one node.
class NodeSystem {
 public:
  // sizes: unknowns of each node, 0 where it is fixed.
  NodeSystem(const std::vector<int>& sizes, int right_sides) {
    for (int size : sizes) {
      offsets_.push_back(total_);
      total_ += size;
    }
    right_ = MatrixXd::Zero(total_, right_sides);
  }
  void Add(int row_node, int column_node, const MatrixXd& block) {
    for (int r = 0; r < block.rows(); ++r) {
      for (int c = 0; c < block.cols(); ++c) {
        entries_.emplace_back(offsets_[row_node] + r, offsets_[column_node] + c, block(r, c));
      }
    }
  }
  void AddRight(int node, const MatrixXd& block) {
    right_.middleRows(offsets_[node], block.rows()) += block;
  }
  int Offset(int node) const { return offsets_[node]; }
  int Size() const { return total_; }

  // The solution nearest to `now` in what is not determined.
  MatrixXd Solve(const MatrixXd& now) {
    Eigen::SparseMatrix<double> matrix(total_, total_);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const double stay = kStay * (matrix.diagonal().sum() / total_ + 1e-12);
    for (int i = 0; i < total_; ++i) entries_.emplace_back(i, i, stay);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
    return factor.solve(right_ + stay * now);
  }

 private:
  std::vector<int> offsets_;
  int total_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
  MatrixXd right_;
};

// One residual a_i^T x_i + b_i - (the landmark's own unknown), weighted; b has a column for each
// right side. The landmark's unknown is eliminated: it is the weighted mean of the rest.
struct Term {
  int node;
  VectorXd coefficients;  // empty for a fixed node
  Eigen::RowVectorXd constant;
  double weight;
};

void AddEliminated(const std::vector<Term>& terms, NodeSystem* system) {
  double total = 0.0;
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(terms.front().constant.size());
  for (const Term& term : terms) {
    total += term.weight;
    mean += term.weight * term.constant;
  }
  mean /= total;
  for (const Term& a : terms) {
    if (a.coefficients.size() == 0) continue;
    system->AddRight(a.node, -a.weight * a.coefficients * (a.constant - mean));
    system->Add(a.node, a.node, a.weight * a.coefficients * a.coefficients.transpose());
    for (const Term& b : terms) {
      if (b.coefficients.size() == 0) continue;
      const double weight = a.weight * b.weight / total;
      system->Add(a.node, b.node, -weight * a.coefficients * b.coefficients.transpose());
    }
  }
}

double Weight(double sigma) { return 1.0 / (sigma * sigma); }

// The rows of R decouple: row r of R_i times n_ik against entry r of N_k, with one matrix for all.
Term RotationTerm(const NodePlane& plane, const NodeState& node) {
  Term term{plane.node, {}, Eigen::RowVectorXd::Zero(3), Weight(plane.tilt_sigma)};
  if (node.fixed) {
    term.constant = (node.world_from_node.rotation * plane.normal).transpose();
  } else {
    term.coefficients = plane.normal;
  }
  return term;
}

Vector3d MeanNormal(const std::vector<NodePlane>& planes, const std::vector<NodeState>& nodes) {
  Vector3d sum = Vector3d::Zero();
  for (const NodePlane& plane : planes) {
    sum += Weight(plane.tilt_sigma) * (nodes[plane.node].world_from_node.rotation * plane.normal);
  }
  return sum.normalized();
}

Term PositionTerm(const NodePlane& plane, const NodeState& node, const Vector3d& normal) {
  Term term{plane.node, {}, Eigen::RowVectorXd::Zero(1), Weight(plane.offset_sigma)};
  const double height = normal.dot(node.world_from_node.rotation * plane.centroid);
  if (node.fixed) {
    term.constant[0] = normal.dot(node.world_from_node * plane.centroid);
  } else if (node.has_scale) {
    term.coefficients = Eigen::Vector4d(normal.x(), normal.y(), normal.z(), height);
  } else {
    term.coefficients = normal;
    term.constant[0] = height;
  }
  return term;
}

}  // namespace

void SolveRotationsJointly(const std::vector<std::vector<NodePlane>>& landmarks,
                           std::vector<NodeState>* nodes) {
  std::vector<int> sizes;
  for (const NodeState& node : *nodes) sizes.push_back(node.fixed ? 0 : 3);
  NodeSystem system(sizes, 3);
  if (system.Size() == 0) return;
  for (const auto& planes : landmarks) {
    if (planes.size() < 2) continue;
    std::vector<Term> terms;
    for (const NodePlane& plane : planes)
      terms.push_back(RotationTerm(plane, (*nodes)[plane.node]));
    AddEliminated(terms, &system);
  }
  MatrixXd now(system.Size(), 3);
  const auto for_each_free = [&](const auto& action) {
    for (std::size_t i = 0; i < nodes->size(); ++i) {
      if (!(*nodes)[i].fixed)
        action((*nodes)[i].world_from_node, system.Offset(static_cast<int>(i)));
    }
  };
  for_each_free([&](const Sim3& pose, int at) {
    now.middleRows<3>(at) = pose.rotation.toRotationMatrix().transpose();
  });
  const MatrixXd solution = system.Solve(now);
  for_each_free([&](Sim3& pose, int at) {
    const Matrix3d relaxed = solution.middleRows<3>(at).transpose();
    if (relaxed.allFinite()) pose.rotation = Eigen::Quaterniond(ProjectToRotation(relaxed));
  });
}

void SolvePositionsJointly(const std::vector<std::vector<NodePlane>>& landmarks,
                           std::vector<NodeState>* nodes) {
  std::vector<int> sizes;
  for (const NodeState& node : *nodes) sizes.push_back(node.fixed ? 0 : node.has_scale ? 4 : 3);
  NodeSystem system(sizes, 1);
  if (system.Size() == 0) return;
  for (const auto& planes : landmarks) {
    if (planes.size() < 2) continue;
    const Vector3d normal = MeanNormal(planes, *nodes);
    std::vector<Term> terms;
    for (const NodePlane& plane : planes) {
      terms.push_back(PositionTerm(plane, (*nodes)[plane.node], normal));
    }
    AddEliminated(terms, &system);
  }
  VectorXd now(system.Size());
  for (std::size_t i = 0; i < nodes->size(); ++i) {
    const NodeState& node = (*nodes)[i];
    const int at = system.Offset(static_cast<int>(i));
    if (!node.fixed) now.segment<3>(at) = node.world_from_node.translation;
    if (!node.fixed && node.has_scale) now[at + 3] = node.world_from_node.scale;
  }
  const VectorXd solution = system.Solve(now);
  if (!solution.allFinite()) return;
  for (std::size_t i = 0; i < nodes->size(); ++i) {
    NodeState& node = (*nodes)[i];
    const int at = system.Offset(static_cast<int>(i));
    if (node.fixed) continue;
    node.world_from_node.translation = solution.segment<3>(at);
    if (node.has_scale && solution[at + 3] > 0.0) node.world_from_node.scale = solution[at + 3];
  }
}

}  // namespace planegraph
