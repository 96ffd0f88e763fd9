#include "solve/information.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

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

// The part H_lp of a plane's normal equations, pose by pose.
struct Coupling {
  int pose;
  Matrix36 block;
};

Matrix36& CouplingOf(int pose, std::vector<Coupling>* couplings) {
  for (Coupling& coupling : *couplings) {
    if (coupling.pose == pose) return coupling.block;
  }
  couplings->push_back({pose, Matrix36::Zero()});
  return couplings->back().block;
}

void AddPosePart(const PlaneResidual& residual, double weight, PoseInformation* information) {
  for (int a = 0; a < residual.block_count; ++a) {
    for (int b = a; b < residual.block_count; ++b) {
      if (residual.blocks[a].kind != BlockKind::kPose) continue;
      if (residual.blocks[b].kind != BlockKind::kPose) continue;
      information->Add(
          residual.blocks[a].index, residual.blocks[b].index,
          weight * residual.linear.jacobians[a].transpose() * residual.linear.jacobians[b]);
    }
  }
}

}  // namespace

void PoseInformation::Add(int row, int column, const Matrix6d& block) {
  const auto key = std::minmax(row, column);
  const auto place = blocks_.try_emplace({key.first, key.second}, Matrix6d::Zero()).first;
  if (row <= column) {
    place->second += block;
  } else {
    place->second += block.transpose();
  }
}

void PoseInformation::Add(const PoseInformation& other) {
  for (const auto& [key, block] : other.blocks_) Add(key.first, key.second, block);
}

Matrix6d PoseInformation::Diagonal(int pose) const {
  const auto found = blocks_.find({pose, pose});
  return found == blocks_.end() ? Matrix6d::Zero() : found->second;
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
        if (residual->blocks[p].kind != BlockKind::kPose) continue;
        CouplingOf(residual->blocks[p].index, &couplings) +=
            jacobians[k].transpose() * jacobians[p];
      }
    }
  }
  if (couplings.empty()) return;
  const Matrix3d inverse = -weight * PseudoInverse(h_ll);
  for (std::size_t a = 0; a < couplings.size(); ++a) {
    const Eigen::Matrix<double, 6, 3> left = couplings[a].block.transpose() * inverse;
    for (std::size_t b = a; b < couplings.size(); ++b) {
      information->Add(couplings[a].pose, couplings[b].pose, left * couplings[b].block);
    }
  }
}

void AddPoseFactorInformation(const LinearizedPoseFactor& factor, PoseInformation* information) {
  for (int a = 0; a < 2 && factor.poses[a] >= 0; ++a) {
    for (int b = a; b < 2 && factor.poses[b] >= 0; ++b) {
      information->Add(factor.poses[a], factor.poses[b],
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
    LinearizedPoseFactor& factor = result.pose_factors.emplace_back();
    factor.index = residual.tag.pose_factor;
    for (int k = 0; k < residual.block_count; ++k) {
      factor.poses[k] = residual.blocks[k].index;
      factor.jacobians[k] = linear.jacobians[k];
    }
  }
  return result;
}

}  // namespace planegraph
