#include "solve/information.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Matrix3n = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 7>;

// Pseudo-inverse of the plane's 3x3 block, judged after scaling to unit diagonal (radians and
// metres). A plane that one weak observation alone sees has directions without information.
Matrix3d PseudoInverse(const Matrix3d& h) {
  const Eigen::Vector3d scale =
      h.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scale.asDiagonal() * h * scale.asDiagonal());
  const Eigen::Vector3d inverse =
      solver.eigenvalues().unaryExpr([](double v) { return v > 1e-12 ? 1.0 / v : 0.0; });
  const Matrix3d scaled =
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
  for (int a = 0; a < residual.block_count; ++a) {
    for (int b = a; b < residual.block_count; ++b) {
      if (residual.blocks[a].kind == BlockKind::kPlane) continue;
      if (residual.blocks[b].kind == BlockKind::kPlane) continue;
      information->Add(
          information->NodeOf(residual.blocks[a]), information->NodeOf(residual.blocks[b]),
          weight * residual.linear.jacobians[a].transpose() * residual.linear.jacobians[b]);
    }
  }
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
    for (int k = 0; k < residual->block_count; ++k) {
      if (residual->blocks[k].kind != BlockKind::kPlane) continue;
      h_ll += jacobians[k].transpose() * jacobians[k];
      for (int p = 0; p < residual->block_count; ++p) {
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

void AddPoseFactorInformation(const LinearizedPoseFactor& factor, PoseInformation* information) {
  for (int a = 0; a < factor.block_count; ++a) {
    for (int b = a; b < factor.block_count; ++b) {
      information->Add(information->NodeOf(factor.blocks[a]), information->NodeOf(factor.blocks[b]),
                       factor.jacobians[a].transpose() * factor.jacobians[b]);
    }
  }
}

LinearizedGraph LinearizeGraph(const Graph& graph, const SolveOptions& options) {
  Assembly assembly(graph, options);
  LinearizedGraph result;
  result.planes.resize(graph.planes.size());
  LinearizedResidual linear;
  for (const Residual& residual : assembly.residuals()) {
    assembly.Linearize(residual, &linear);
    if (residual.tag.plane >= 0) {
      result.planes[residual.tag.plane].push_back(
          {residual.blocks, residual.block_count, residual.tag, linear});
      continue;
    }
    result.pose_factors.push_back(
        {residual.tag, residual.blocks, residual.block_count, linear.jacobians});
  }
  return result;
}

}  // namespace planegraph
