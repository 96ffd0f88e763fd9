#include "solve/group_system.h"

namespace planegraph {

using Eigen::Matrix3d;
using Eigen::MatrixXd;

GroupSystem::GroupSystem(const std::vector<const PlaneResidual*>& residuals,
                         const PoseInformation& nodes)
    : numbers_(nodes) {
  for (const PlaneResidual* residual : residuals) Place(*residual);
  h_ll_ = m_ll_ = MatrixXd::Zero(planes_, planes_);
  h_lp_ = m_lp_ = MatrixXd::Zero(planes_, rows_);
  for (const PlaneResidual* residual : residuals) Add(*residual);
  inverse_ = PseudoInverse(h_ll_);
  following_ = inverse_ * h_lp_;
}

void GroupSystem::Place(const PlaneResidual& residual) {
  for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
    const BlockRef& block = residual.blocks[k];
    const int size = static_cast<int>(residual.linear.jacobians[k].cols());
    if (block.kind == BlockKind::kPlane) {
      if (place_.try_emplace(block.index, planes_).second) planes_ += size;
    } else if (nodes_.try_emplace(numbers_.NodeOf(block), rows_, size).second) {
      rows_ += size;
    }
  }
}

void GroupSystem::Add(const PlaneResidual& residual) {
  const auto& jacobians = residual.linear.jacobians;
  for (std::size_t l = 0; l < residual.blocks.size(); ++l) {
    if (residual.blocks[l].kind != BlockKind::kPlane) continue;
    const int row = place_.at(residual.blocks[l].index);
    const MatrixXd left = jacobians[l].transpose();
    const MatrixXd scattered =
        residual.scatter.size() > 0 ? MatrixXd(left * residual.scatter.asDiagonal()) : left;
    for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
      const BlockRef& block = residual.blocks[k];
      const bool is_plane = block.kind == BlockKind::kPlane;
      const int column =
          is_plane ? place_.at(block.index) : nodes_.at(numbers_.NodeOf(block)).first;
      const Eigen::Index size = jacobians[k].cols();
      (is_plane ? h_ll_ : h_lp_).block(row, column, 3, size) += left * jacobians[k];
      (is_plane ? m_ll_ : m_lp_).block(row, column, 3, size) += scattered * jacobians[k];
    }
  }
}

MatrixXd GroupSystem::ScatterReduction() const {
  const MatrixXd half = following_.transpose() * (0.5 * m_ll_ * following_ - m_lp_);
  return half + half.transpose();
}

MatrixXd GroupSystem::ByPlanes(const PlaneResidual& residual) const {
  MatrixXd result = MatrixXd::Zero(residual.linear.residual.size(), planes_);
  for (std::size_t k = 0; k < residual.blocks.size(); ++k) {
    if (residual.blocks[k].kind != BlockKind::kPlane) continue;
    result.middleCols<3>(place_.at(residual.blocks[k].index)) += residual.linear.jacobians[k];
  }
  return result;
}

PlaneElimination GroupSystem::Eliminate(int plane) const {
  PlaneElimination elimination;
  const auto place = place_.find(plane);
  if (place == place_.end()) return elimination;
  const MatrixXd rows = inverse_.middleRows<3>(place->second);
  elimination.covariance = rows * m_ll_ * rows.transpose();
  // Where nothing is missing, the pseudo-inverse is the inverse.
  MatrixXd missing = -rows * h_ll_;
  missing.middleCols<3>(place->second) += Matrix3d::Identity();
  elimination.determined = missing.cwiseAbs().maxCoeff() < 1e-3;
  const MatrixXd by_nodes = -following_.middleRows<3>(place->second);
  const MatrixXd with_scores = rows * (m_lp_ - m_ll_ * following_);
  for (const auto& [node, at] : nodes_) {
    elimination.by_nodes.emplace_back(node, by_nodes.middleCols(at.first, at.second));
    elimination.with_scores.emplace_back(node, with_scores.middleCols(at.first, at.second));
  }
  return elimination;
}

}  // namespace planegraph
