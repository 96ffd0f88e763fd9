#include "solve/information.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "planegraph/base/disjoint_sets.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Matrix3n = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 7>;

// Pseudo-inverse of a plane's 3x3 block (or that of several), judged after scaling to unit diagonal
// (radians and metres). A plane that one weak observation alone sees has directions without
// information.
template <typename Matrix>
Matrix PseudoInverse(const Matrix& h) {
  using Vector = Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1>;
  const Vector scale =
      h.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(scale.asDiagonal() * h * scale.asDiagonal());
  const Vector inverse =
      solver.eigenvalues().unaryExpr([](double v) { return v > 1e-12 ? 1.0 / v : 0.0; });
  const Matrix scaled =
      solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
  return scale.asDiagonal() * scaled * scale.asDiagonal();
}

// The part H_lp of a plane's normal equations, node by node.
struct Coupling {
  int node;
  Matrix3n block;
};

void AddCoupling(int node, const Matrix3n& block, std::vector<Coupling>* couplings) {
  for (Coupling& coupling : *couplings) {
    if (coupling.node != node) continue;
    coupling.block += block;
    return;
  }
  couplings->push_back({node, block});
}

void AddPosePart(const PlaneResidual& residual, double weight, PoseInformation* information) {
  for (std::size_t a = 0; a < residual.blocks.size(); ++a) {
    for (std::size_t b = a; b < residual.blocks.size(); ++b) {
      if (residual.blocks[a].kind == BlockKind::kPlane) continue;
      if (residual.blocks[b].kind == BlockKind::kPlane) continue;
      information->Add(
          information->NodeOf(residual.blocks[a]), information->NodeOf(residual.blocks[b]),
          weight * residual.linear.jacobians[a].transpose() * residual.linear.jacobians[b]);
    }
  }
}

// The normal equations of planes that are eliminated together.
class GroupSystem {
 public:
  GroupSystem(const std::vector<const PlaneResidual*>& residuals, const PoseInformation& nodes) {
    for (const PlaneResidual* residual : residuals) Place(*residual, nodes);
    h_ll_ = Eigen::MatrixXd::Zero(planes_, planes_);
    h_lp_ = Eigen::MatrixXd::Zero(planes_, rows_);
    for (const PlaneResidual* residual : residuals) Add(*residual, nodes);
  }

  // First row and dimension of each node in the reduction.
  const std::map<int, std::pair<int, int>>& nodes() const { return nodes_; }
  Eigen::MatrixXd Reduction() const { return -h_lp_.transpose() * PseudoInverse(h_ll_) * h_lp_; }
  PlaneElimination Eliminate(int plane) const;

 private:
  void Place(const PlaneResidual& residual, const PoseInformation& nodes) {
    for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
      const BlockRef& block = residual.blocks[k];
      const int size = static_cast<int>(residual.linear.jacobians[k].cols());
      if (block.kind == BlockKind::kPlane) {
        if (place_.try_emplace(block.index, planes_).second) planes_ += size;
      } else if (nodes_.try_emplace(nodes.NodeOf(block), rows_, size).second) {
        rows_ += size;
      }
    }
  }

  void Add(const PlaneResidual& residual, const PoseInformation& nodes) {
    const auto& jacobians = residual.linear.jacobians;
    for (std::size_t l = 0; l < residual.blocks.size(); ++l) {
      if (residual.blocks[l].kind != BlockKind::kPlane) continue;
      const int row = place_.at(residual.blocks[l].index);
      for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
        const BlockRef& block = residual.blocks[k];
        const bool is_plane = block.kind == BlockKind::kPlane;
        const Eigen::MatrixXd product = jacobians[l].transpose() * jacobians[k];
        const int column = is_plane ? place_.at(block.index) : nodes_.at(nodes.NodeOf(block)).first;
        (is_plane ? h_ll_ : h_lp_).block(row, column, product.rows(), product.cols()) += product;
      }
    }
  }

  std::map<int, int> place_;  // first row of each plane
  std::map<int, std::pair<int, int>> nodes_;
  int planes_ = 0, rows_ = 0;
  Eigen::MatrixXd h_ll_, h_lp_;
};

PlaneElimination GroupSystem::Eliminate(int plane) const {
  PlaneElimination elimination;
  const auto place = place_.find(plane);
  if (place == place_.end()) return elimination;
  const Eigen::MatrixXd rows = PseudoInverse(h_ll_).middleRows<3>(place->second);
  elimination.covariance = rows.middleCols<3>(place->second);
  // Where nothing is missing, the pseudo-inverse is the inverse.
  const Eigen::MatrixXd unit = rows * h_ll_;
  Eigen::MatrixXd missing = -unit;
  missing.middleCols<3>(place->second) += Matrix3d::Identity();
  elimination.determined = missing.cwiseAbs().maxCoeff() < 1e-3;
  const Eigen::MatrixXd by_nodes = -rows * h_lp_;
  for (const auto& [node, at] : nodes_) {
    elimination.by_nodes.emplace_back(node, by_nodes.middleCols(at.first, at.second));
  }
  return elimination;
}

}  // namespace

void PoseInformation::Add(int row, int column, const NodeBlock& block) {
  const auto key = std::minmax(row, column);
  const NodeBlock upper = row <= column ? block : NodeBlock(block.transpose());
  const auto [place, is_new] = blocks_.try_emplace({key.first, key.second}, upper);
  if (!is_new) place->second += upper;
}

Matrix6d PoseInformation::Diagonal(int pose) const {
  const auto found = blocks_.find({pose, pose});
  return found == blocks_.end() ? Matrix6d::Zero() : Matrix6d(found->second);
}

void AddPlaneInformation(const std::vector<const PlaneResidual*>& residuals, double weight,
                         PoseInformation* information) {
  Matrix3d h_ll = Matrix3d::Zero();
  std::vector<Coupling> couplings;
  for (const PlaneResidual* residual : residuals) {
    AddPosePart(*residual, weight, information);
    const auto& jacobians = residual->linear.jacobians;
    const std::size_t count = residual->blocks.size();
    for (std::size_t k = 0; k < count; ++k) {
      if (residual->blocks[k].kind != BlockKind::kPlane) continue;
      h_ll += jacobians[k].transpose() * jacobians[k];
      for (std::size_t p = 0; p < count; ++p) {
        if (residual->blocks[p].kind == BlockKind::kPlane) continue;
        AddCoupling(information->NodeOf(residual->blocks[p]),
                    jacobians[k].transpose() * jacobians[p], &couplings);
      }
    }
  }
  if (couplings.empty()) return;
  const Matrix3d inverse = -weight * PseudoInverse(h_ll);
  for (std::size_t a = 0; a < couplings.size(); ++a) {
    const NodeBlock left = couplings[a].block.transpose() * inverse;
    for (std::size_t b = a; b < couplings.size(); ++b) {
      information->Add(couplings[a].node, couplings[b].node, left * couplings[b].block);
    }
  }
}

void AddPlaneGroupInformation(const std::vector<const PlaneResidual*>& residuals,
                              PoseInformation* information) {
  for (const PlaneResidual* residual : residuals) AddPosePart(*residual, 1.0, information);
  const GroupSystem system(residuals, *information);
  const Eigen::MatrixXd reduction = system.Reduction();
  for (const auto& [a, at] : system.nodes()) {
    for (const auto& [b, to] : system.nodes()) {
      if (b < a) continue;
      information->Add(a, b, reduction.block(at.first, to.first, at.second, to.second));
    }
  }
}

PlaneGroups::PlaneGroups(const LinearizedGraph& linear)
    : linear_(linear), planes_(linear.planes.size()), ties_(linear.planes.size()) {
  DisjointSets sets(linear.planes.size());
  for (const PlaneResidual& tie : linear.plane_factors) {
    sets.Join(tie.blocks[0].index, tie.blocks[1].index);
  }
  for (std::size_t k = 0; k < linear.planes.size(); ++k) {
    group_.push_back(sets.Find(k));
    planes_[group_[k]].push_back(k);
  }
  for (std::size_t t = 0; t < linear.plane_factors.size(); ++t) {
    ties_[group_[linear.plane_factors[t].blocks[0].index]].push_back(t);
  }
}

std::vector<const PlaneResidual*> PlaneGroups::Residuals(int plane) const {
  std::vector<const PlaneResidual*> residuals;
  for (const std::size_t t : ties_[group_[plane]]) residuals.push_back(&linear_.plane_factors[t]);
  for (const std::size_t k : planes_[group_[plane]]) {
    for (const PlaneResidual& residual : linear_.planes[k]) residuals.push_back(&residual);
  }
  return residuals;
}

bool PlaneGroups::IsFirst(int plane) const {
  return group_[plane] == static_cast<std::size_t>(plane);
}

bool PlaneGroups::IsTied(int plane) const { return !ties_[group_[plane]].empty(); }

PlaneElimination EliminatePlane(const std::vector<const PlaneResidual*>& residuals,
                                const PoseInformation& nodes, int plane) {
  return GroupSystem(residuals, nodes).Eliminate(plane);
}

void AddAllPlaneInformation(const LinearizedGraph& linear, PoseInformation* information) {
  const PlaneGroups groups(linear);
  for (int k = 0; k < static_cast<int>(linear.planes.size()); ++k) {
    if (!groups.IsFirst(k)) continue;
    if (groups.IsTied(k)) {
      AddPlaneGroupInformation(groups.Residuals(k), information);
    } else {
      AddPlaneInformation(groups.Residuals(k), 1.0, information);
    }
  }
}

void AddPoseFactorInformation(const LinearizedPoseFactor& factor, PoseInformation* information) {
  for (std::size_t a = 0; a < factor.blocks.size(); ++a) {
    for (std::size_t b = a; b < factor.blocks.size(); ++b) {
      information->Add(information->NodeOf(factor.blocks[a]), information->NodeOf(factor.blocks[b]),
                       factor.jacobians[a].transpose() * factor.jacobians[b]);
    }
  }
}

LinearizedGraph LinearizeGraph(const Graph& graph, const SolveOptions& options) {
  SolveOptions by_observations = options;
  const FactorType& type = BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);
  if (!type.linearized_as.empty()) {
    by_observations.plane_factor = type.linearized_as;
    by_observations.plane_factor_options.clear();
  }
  Assembly assembly(graph, by_observations);
  LinearizedGraph result;
  result.planes.resize(graph.planes.size());
  LinearizedResidual linear;
  for (const Residual& residual : assembly.residuals()) {
    assembly.Linearize(residual, &linear);
    if (residual.tag.plane >= 0) {
      result.planes[residual.tag.plane].push_back({residual.blocks, residual.tag, linear});
      continue;
    }
    if (residual.tag.plane_factor >= 0) {
      result.plane_factors.push_back({residual.blocks, residual.tag, linear});
      continue;
    }
    result.pose_factors.push_back({residual.tag, residual.blocks, linear.jacobians});
  }
  return result;
}

}  // namespace planegraph
