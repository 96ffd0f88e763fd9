#include "planegraph/solve/covariance.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <map>

#include "planegraph/geometry/rotation.h"
#include "solve/pose_system.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A quantity of six dimensions, linear in the perturbations of the poses and maps: its derivative
// (rows: 6 for each pose, then 7 for each map), and the poses whose scales tell when a variance of
// it is infinite.
struct Quantity {
  MatrixXd by_poses;
  std::vector<int> scale_poses;
};

Eigen::Index Dimensions(const Graph& graph) {
  return static_cast<Eigen::Index>(6 * graph.poses.size() + 7 * graph.maps.size());
}

Quantity PoseQuantity(const Graph& graph, int pose) {
  Quantity quantity{MatrixXd::Zero(6, Dimensions(graph)), {pose}};
  quantity.by_poses.middleCols<6>(6 * pose).setIdentity();
  return quantity;
}

// target_from_source in the target's axes: x = R_t^T (x_s - x_t - r_t x d), r = R_t^T (r_s - r_t).
Quantity RelativeQuantity(const Graph& graph, int target, int source) {
  const Rigid3& a = graph.poses[target].world_from_node;
  const Rigid3& b = graph.poses[source].world_from_node;
  const Matrix3d to_target = a.rotation.toRotationMatrix().transpose();
  Quantity quantity{MatrixXd::Zero(6, Dimensions(graph)), {source, target}};
  Matrix6d by_source = Matrix6d::Zero();
  by_source.topLeftCorner<3, 3>() = to_target;
  by_source.bottomRightCorner<3, 3>() = to_target;
  Matrix6d by_target = -by_source;
  by_target.topRightCorner<3, 3>() = to_target * Hat(b.translation - a.translation);
  quantity.by_poses.middleCols<6>(6 * source) += by_source;
  quantity.by_poses.middleCols<6>(6 * target) += by_target;
  return quantity;
}

}  // namespace

class GraphCovariance::Implementation {
 public:
  Implementation(const Graph& graph, const SolveOptions& options,
                 const CovarianceOptions& covariance_options)
      : graph_(graph), options_(covariance_options) {
    const LinearizedGraph linear = LinearizeGraph(graph, options);
    PoseInformation information(graph.poses.size());
    AddAllPlaneInformation(linear, &information);
    planes_ = std::make_unique<PoseSystem>(information, GaugeFixed(graph, false));
    for (const auto& factor : linear.pose_factors) AddPoseFactorInformation(factor, &information);
    all_ = std::make_unique<PoseSystem>(information, GaugeFixed(graph, true));
    pose_factors_ = linear.pose_factors;
  }

  const Graph& graph() const { return graph_; }

  // Of several quantities, one after the other.
  MatrixXd Covariance(const std::vector<Quantity>& quantities) const {
    const auto count = static_cast<Eigen::Index>(quantities.size());
    MatrixXd by_poses(6 * count, Dimensions(graph_));
    for (Eigen::Index q = 0; q < count; ++q) {
      by_poses.middleRows<6>(6 * q) = quantities[q].by_poses;
    }
    MatrixXd covariance = Raw(*all_, by_poses);
    for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
      if (covariance(k, k) <= Limit(*all_, quantities[k / 6], k % 6 >= 3)) continue;
      covariance.row(k).setConstant(kNotANumber);
      covariance.col(k).setConstant(kNotANumber);
    }
    return covariance;
  }

  Matrix7d MapCovariance(int map) const {
    const Eigen::Index first =
        Dimensions(graph_) - 7 * static_cast<int>(graph_.maps.size()) + 7 * map;
    MatrixXd by_nodes = MatrixXd::Zero(7, Dimensions(graph_));
    by_nodes.middleCols<7>(first).setIdentity();
    const Matrix7d covariance = by_nodes * all_->Solve(by_nodes.transpose());
    return 0.5 * (covariance + covariance.transpose());
  }

  std::vector<UnobservedDirection> Unobserved(const Quantity& quantity) const {
    std::vector<UnobservedDirection> found;
    const Matrix6d by_planes = Raw(*planes_, quantity.by_poses);
    for (const bool rotation : {false, true}) {
      const double threshold =
          rotation ? options_.rotation_threshold : options_.translation_threshold;
      const int first = rotation ? 3 : 0;
      const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(
          Matrix3d(by_planes.block<3, 3>(first, first)));
      for (int k = 2; k >= 0; --k) {
        if (solver.eigenvalues()[k] <= threshold * threshold) break;
        Vector6d direction = Vector6d::Zero();
        direction.segment<3>(first) = solver.eigenvectors().col(k);
        found.push_back(Describe(quantity, direction, rotation));
      }
    }
    return found;
  }

 private:
  static MatrixXd Raw(const PoseSystem& system, const MatrixXd& by_poses) {
    const MatrixXd covariance = by_poses * system.Solve(by_poses.transpose());
    return 0.5 * (covariance + covariance.transpose());
  }

  static double Limit(const PoseSystem& system, const Quantity& quantity, bool rotation) {
    double limit = kInfinity;
    for (const int pose : quantity.scale_poses) {
      limit = std::min(limit, system.InfiniteVariance(pose, rotation));
    }
    return limit;
  }

  UnobservedDirection Describe(const Quantity& quantity, Vector6d direction, bool rotation) const {
    // The sign is free; the largest component is made positive.
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    if (direction[largest] < 0.0) direction = -direction;
    const Eigen::VectorXd gradient = quantity.by_poses.transpose() * direction;
    const Eigen::VectorXd response = all_->Solve(gradient);
    const double variance = gradient.dot(response);
    UnobservedDirection result{direction, kInfinity, ""};
    if (variance > Limit(*all_, quantity, rotation)) return result;
    result.sigma = std::sqrt(std::max(variance, 0.0));
    result.held_by = Holder(response);
    return result;
  }

  // The variance g^T H^-1 g is x^T H x with x = H^-1 g, and H is the sum of its factors: each has
  // its share in holding the direction.
  std::string Holder(const Eigen::VectorXd& response) const {
    std::map<std::string, double> shares;
    for (const LinearizedPoseFactor& factor : pose_factors_) {
      Eigen::VectorXd moved = Eigen::VectorXd::Zero(factor.jacobians[0].rows());
      for (std::size_t k = 0; k < factor.blocks.size(); ++k) {
        moved += factor.jacobians[k] *
                 response.segment(FirstRow(factor.blocks[k]), factor.jacobians[k].cols());
      }
      shares[SourceOf(factor)] += moved.squaredNorm();
    }
    std::string holder;
    double best = 0.0;
    for (const auto& [source, share] : shares) {
      if (share > best) holder = source, best = share;
    }
    return holder;
  }

  Eigen::Index FirstRow(const BlockRef& block) const {
    const auto poses = static_cast<Eigen::Index>(graph_.poses.size());
    return block.kind == BlockKind::kMap ? 6 * poses + 7 * block.index : 6 * block.index;
  }

  const std::string& SourceOf(const LinearizedPoseFactor& factor) const {
    return factor.tag.map_factor >= 0 ? graph_.map_factors[factor.tag.map_factor].source
                                      : graph_.pose_factors[factor.tag.pose_factor].source;
  }

  Graph graph_;
  CovarianceOptions options_;
  std::vector<LinearizedPoseFactor> pose_factors_;
  std::unique_ptr<PoseSystem> planes_, all_;
};

GraphCovariance::GraphCovariance(const Graph& graph, const SolveOptions& options,
                                 const CovarianceOptions& covariance_options) {
  CheckGraph(graph);
  implementation_ = std::make_unique<Implementation>(graph, options, covariance_options);
}

GraphCovariance::~GraphCovariance() = default;

Matrix6d GraphCovariance::Pose(int pose) const {
  return implementation_->Covariance({PoseQuantity(implementation_->graph(), pose)});
}

Matrix6d GraphCovariance::Relative(int target, int source) const {
  return implementation_->Covariance({RelativeQuantity(implementation_->graph(), target, source)});
}

Eigen::MatrixXd GraphCovariance::Relatives(int target, const std::vector<int>& sources) const {
  std::vector<Quantity> quantities;
  for (const int source : sources) {
    quantities.push_back(RelativeQuantity(implementation_->graph(), target, source));
  }
  return implementation_->Covariance(quantities);
}

Matrix7d GraphCovariance::Map(int map) const { return implementation_->MapCovariance(map); }

std::vector<UnobservedDirection> GraphCovariance::Unobserved(int pose) const {
  return implementation_->Unobserved(PoseQuantity(implementation_->graph(), pose));
}

std::vector<UnobservedDirection> GraphCovariance::UnobservedRelative(int target, int source) const {
  return implementation_->Unobserved(RelativeQuantity(implementation_->graph(), target, source));
}

}  // namespace planegraph
