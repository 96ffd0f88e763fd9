#include "solve/information.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/disjoint_sets.h"
#include "solve/group_system.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Matrix3n = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 7>;

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

// J_a^T F J_b of two blocks of a residual.
Eigen::MatrixXd ScatterOf(const PlaneResidual& residual, std::size_t a, std::size_t b) {
  const auto& jacobians = residual.linear.jacobians;
  if (residual.scatter.size() == 0) return jacobians[a].transpose() * jacobians[b];
  return jacobians[a].transpose() * residual.scatter.asDiagonal() * jacobians[b];
}

void AddPoseScatter(const PlaneResidual& residual, PoseInformation* scatter) {
  for (std::size_t a = 0; a < residual.blocks.size(); ++a) {
    for (std::size_t b = a; b < residual.blocks.size(); ++b) {
      if (residual.blocks[a].kind == BlockKind::kPlane) continue;
      if (residual.blocks[b].kind == BlockKind::kPlane) continue;
      scatter->Add(scatter->NodeOf(residual.blocks[a]), scatter->NodeOf(residual.blocks[b]),
                   ScatterOf(residual, a, b));
    }
  }
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

void AddReduction(const GroupSystem& system, const Eigen::MatrixXd& reduction,
                  PoseInformation* information) {
  for (const auto& [a, at] : system.nodes()) {
    for (const auto& [b, to] : system.nodes()) {
      if (b < a) continue;
      information->Add(a, b, reduction.block(at.first, to.first, at.second, to.second));
    }
  }
}

}  // namespace

void PoseInformation::Add(int row, int column, const NodeBlock& block) {
  const auto [low, high] = std::minmax(row, column);
  if (low >= static_cast<int>(rows_.size())) rows_.resize(low + 1);
  std::vector<Entry>& entries = rows_[low];
  const auto found = std::lower_bound(entries.begin(), entries.end(), Entry(high, 0));
  if (found == entries.end() || found->first != high) {
    entries.insert(found, {high, blocks_.size()});
    blocks_.push_back(row <= column ? block : NodeBlock(block.transpose()));
  } else if (row <= column) {
    blocks_[found->second] += block;
  } else {
    blocks_[found->second] += block.transpose();
  }
}

const NodeBlock* PoseInformation::Find(int row, int column) const {
  if (row >= static_cast<int>(rows_.size())) return nullptr;
  const std::vector<Entry>& entries = rows_[row];
  const auto found = std::lower_bound(entries.begin(), entries.end(), Entry(column, 0));
  const bool there = found != entries.end() && found->first == column;
  return there ? &blocks_[found->second] : nullptr;
}

Matrix6d PoseInformation::Diagonal(int pose) const {
  const NodeBlock* found = Find(pose, pose);
  return found == nullptr ? Matrix6d::Zero() : Matrix6d(*found);
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
  AddReduction(system, system.Reduction(), information);
}

void AddPlaneGroupScatter(const std::vector<const PlaneResidual*>& residuals,
                          PoseInformation* scatter) {
  for (const PlaneResidual* residual : residuals) AddPoseScatter(*residual, scatter);
  const GroupSystem system(residuals, *scatter);
  AddReduction(system, system.ScatterReduction(), scatter);
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
      result.planes[residual.tag.plane].push_back({residual.blocks, residual.tag, linear, {}, {}});
      continue;
    }
    if (residual.tag.plane_factor >= 0) {
      result.plane_factors.push_back({residual.blocks, residual.tag, linear, {}, {}});
      continue;
    }
    result.pose_factors.push_back({residual.tag, residual.blocks, linear.jacobians});
  }
  return result;
}

}  // namespace planegraph
