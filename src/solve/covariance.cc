#include "planegraph/solve/covariance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "solve/open_motions.h"
#include "solve/quantity.h"
#include "solve/residual_scatter.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Quantity PoseQuantity(int pose) { return {{pose, Matrix6d::Identity()}}; }

// target_from_source in the target's axes: x = R_t^T (x_s - x_t - r_t x d), r = R_t^T (r_s - r_t).
Quantity RelativeQuantity(const Graph& graph, int target, int source) {
  const Rigid3& a = graph.poses[target].world_from_node;
  const Rigid3& b = graph.poses[source].world_from_node;
  const Matrix3d to_target = a.rotation.toRotationMatrix().transpose();
  Matrix6d by_source = Matrix6d::Zero();
  by_source.topLeftCorner<3, 3>() = to_target;
  by_source.bottomRightCorner<3, 3>() = to_target;
  Matrix6d by_target = -by_source;
  by_target.topRightCorner<3, 3>() = to_target * Hat(b.translation - a.translation);
  return {{target, by_target}, {source, by_source}};
}

MatrixXd Symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

void SetUnknown(const PoseSystem& system, const Quantity& quantity, Eigen::Index first,
                MatrixXd* covariance) {
  for (Eigen::Index k = first; k < first + 6; ++k) {
    if ((*covariance)(k, k) <= InfiniteVariance(system, quantity, k - first >= 3)) continue;
    covariance->row(k).setConstant(kNotANumber);
    covariance->col(k).setConstant(kNotANumber);
  }
}

}  // namespace

class GraphCovariance::Implementation {
 public:
  Implementation(const Graph& graph, const SolveOptions& options,
                 const CovarianceOptions& covariance_options)
      : graph_(graph),
        options_(covariance_options),
        linear_(LinearizeGraph(graph, options)),
        groups_(linear_) {
    // What is observed is asked of the stated noise: a threshold on geometry.
    plane_information_ = std::make_unique<PoseInformation>(NodeNumbers(graph));
    AddAllPlaneInformation(linear_, plane_information_.get());
    const bool by_residuals =
        covariance_options.noise == CovarianceNoise::kResiduals && HasPlanes(options);
    if (!by_residuals) all_ = AllSystem(*plane_information_);
    AddTies();
    planes_ = std::make_unique<PoseSystem>(*plane_information_, GaugeFixed(graph, false));
    if (by_residuals) SetByResiduals();
  }

  const Graph& graph() const { return graph_; }
  const CovarianceOptions& options() const { return options_; }

  Matrix6d Covariance(const Quantity& quantity) const {
    MatrixXd covariance = CovarianceOf(*all_, quantity);
    SetUnknown(*all_, quantity, 0, &covariance);
    return covariance;
  }

  // Of several quantities of six dimensions, one after the other.
  MatrixXd JointCovariance(const std::vector<Quantity>& quantities) const {
    const auto count = static_cast<Eigen::Index>(quantities.size());
    MatrixXd gradients(all_->rows(), 6 * count);
    for (Eigen::Index q = 0; q < count; ++q) {
      gradients.middleCols<6>(6 * q) = Gradient(*all_, quantities[q]);
    }
    MatrixXd covariance = Symmetric(all_->CovarianceOf(gradients));
    for (Eigen::Index q = 0; q < count; ++q) SetUnknown(*all_, quantities[q], 6 * q, &covariance);
    return covariance;
  }

  Matrix7d MapCovariance(int map) const {
    const int node = NodeNumbers(graph_).Of({BlockKind::kMap, map});
    Matrix7d covariance = Symmetric(all_->Covariance(node, node));
    SetUnknownOfMap({node}, &covariance);
    return covariance;
  }

  Matrix7d MeanOfMaps(const std::vector<std::pair<int, Matrix7d>>& by_maps) const {
    Quantity quantity;
    std::vector<int> nodes;
    for (const auto& [map, derivative] : by_maps) {
      nodes.push_back(NodeNumbers(graph_).Of({BlockKind::kMap, map}));
      quantity.push_back({nodes.back(), derivative});
    }
    // By solving once: the blocks between tiles that are far from each other are not at hand.
    Matrix7d covariance = Symmetric(all_->CovarianceOf(Gradient(*all_, quantity)));
    SetUnknownOfMap(nodes, &covariance);
    return covariance;
  }

  double ScaleVariance(int scale) const {
    const int node = NodeNumbers(graph_).Of({BlockKind::kScale, scale});
    return all_->Covariance(node, node)(0, 0);
  }

  // What the observations alone leave, and what of the poses' errors goes through.
  Matrix3d PlaneCovariance(int plane) const {
    const PoseInformation nodes{NodeNumbers(graph_)};
    const PlaneElimination elimination = EliminatePlane(groups_.Residuals(plane), nodes, plane);
    if (!elimination.determined) return Matrix3d::Constant(kNotANumber);
    Matrix3d covariance = elimination.covariance;
    if (!elimination.by_nodes.empty()) covariance += CovarianceOf(*all_, elimination.by_nodes);
    // The poses' errors come from the same observations.
    Matrix3d common = Matrix3d::Zero();
    for (const auto& [a, with_scores] : elimination.with_scores) {
      for (const auto& [b, by_node] : elimination.by_nodes) {
        common += with_scores * all_->Block(a, b) * by_node.transpose();
      }
    }
    return covariance + common + common.transpose();
  }

  std::vector<UnobservedDirection> Unobserved(const Quantity& quantity) const {
    std::vector<UnobservedDirection> found;
    const Matrix6d by_planes = CovarianceOf(*planes_, quantity);
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

  std::vector<OpenMotion> OpenMotions() const {
    std::vector<OpenMotion> motions = FindOpenMotions(graph_, *plane_information_, options_);
    for (OpenMotion& motion : motions) SetSigma(&motion);
    return motions;
  }

 private:
  // Pairs of observations, of which each takes part in many, are no residuals of a plane.
  static bool HasPlanes(const SolveOptions& options) {
    const FactorType& type = BuiltinFactors().Get(options.plane_factor, FactorKind::kPlane);
    return type.plane_blocks || !type.linearized_as.empty();
  }

  void SetUnknownOfMap(const std::vector<int>& nodes, Matrix7d* covariance) const {
    for (int k = 0; k < 7; ++k) {
      double limit = kInfinity;
      for (const int node : nodes) limit = std::min(limit, all_->InfiniteVariance(node, k));
      if ((*covariance)(k, k) <= limit) continue;
      covariance->row(k).setConstant(kNotANumber);
      covariance->col(k).setConstant(kNotANumber);
    }
  }

  void AddTies() {
    for (const LinearizedPoseFactor& factor : linear_.pose_factors) {
      if (TiesMaps(graph_, factor)) AddPoseFactorInformation(factor, plane_information_.get());
    }
  }

  std::unique_ptr<PoseSystem> AllSystem(PoseInformation information) const {
    for (const auto& factor : linear_.pose_factors) AddPoseFactorInformation(factor, &information);
    return std::make_unique<PoseSystem>(information, GaugeFixed(graph_, true));
  }

  void SetByResiduals() {
    ApplyLossCurvature(&linear_);
    const NodeNumbers numbers(graph_);
    PoseInformation information(numbers);
    AddAllPlaneInformation(linear_, &information);
    all_ = AllSystem(std::move(information));
    SetResidualScatter(*all_, numbers, &linear_);
    all_->SetScatter(ScoreScatter(linear_, numbers));
  }

  // The largest of the motion's sigmas over the nodes that share it: over so many of them at most.
  void SetSigma(OpenMotion* motion) const {
    constexpr std::size_t kMost = 64;
    motion->sigma = 0.0;
    const std::vector<int> nodes = SharingNodes(*motion);
    const std::size_t step = (nodes.size() + kMost - 1) / kMost;
    for (std::size_t k = 0; k < nodes.size(); k += step) {
      const Quantity quantity = MotionQuantity(*motion, nodes[k]);
      const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(CovarianceOf(*all_, quantity));
      const double variance = solver.eigenvalues()[solver.eigenvalues().size() - 1];
      const bool rotation = motion->kind == MotionKind::kRotation;
      // Where the gauge holds both, each is the world of its own part.
      const bool infinite =
          !(variance <= InfiniteVariance(*all_, quantity, rotation) && variance > 0.0);
      const double sigma = infinite ? kInfinity : std::sqrt(variance);
      if (sigma <= motion->sigma) continue;
      motion->sigma = sigma;
      motion->node = nodes[k];
      const VectorXd worst = solver.eigenvectors().rightCols<1>();
      motion->held_by = infinite ? ""
                                 : HolderOf(graph_, linear_, *all_,
                                            all_->Solve(Gradient(*all_, quantity) * worst));
    }
  }

  Quantity MotionQuantity(const OpenMotion& motion, int node) const {
    if (motion.kind == MotionKind::kScale) {
      return {{node, Eigen::RowVectorXd::Unit(7, 6)}};
    }
    MatrixXd axes = Matrix3d::Identity();
    if (!motion.axes.empty()) axes.resize(3, static_cast<Eigen::Index>(motion.axes.size()));
    for (std::size_t k = 0; k < motion.axes.size(); ++k) {
      axes.col(static_cast<Eigen::Index>(k)) = motion.axes[k];
    }
    const int first = motion.kind == MotionKind::kRotation ? 3 : 0;
    const SeenMotion seen = MotionSeenFrom(graph_, motion.reference, node);
    return {{motion.reference, axes.transpose() * seen.by_i.middleRows<3>(first)},
            {node, axes.transpose() * seen.by_k.middleRows<3>(first)}};
  }

  static std::vector<int> SharingNodes(const OpenMotion& motion) {
    if (motion.parts.size() < 2) return {motion.node};
    std::vector<int> nodes;
    for (const auto& part : motion.parts) {
      if (std::find(part.begin(), part.end(), motion.reference) != part.end()) continue;
      nodes.insert(nodes.end(), part.begin(), part.end());
    }
    return nodes;
  }

  UnobservedDirection Describe(const Quantity& quantity, Vector6d direction, bool rotation) const {
    // The sign is free; the largest component is made positive.
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    if (direction[largest] < 0.0) direction = -direction;
    const VectorXd gradient = Gradient(*all_, quantity) * direction;
    const VectorXd response = all_->Solve(gradient);
    const double variance = all_->CovarianceOf(gradient)(0, 0);
    UnobservedDirection result{direction, kInfinity, ""};
    if (!(variance <= InfiniteVariance(*all_, quantity, rotation))) return result;
    result.sigma = std::sqrt(std::max(variance, 0.0));
    result.held_by = HolderOf(graph_, linear_, *all_, response);
    return result;
  }

  Graph graph_;
  CovarianceOptions options_;
  LinearizedGraph linear_;
  PlaneGroups groups_;
  std::unique_ptr<PoseInformation> plane_information_;
  std::unique_ptr<PoseSystem> planes_, all_;
};

std::string Name(CovarianceNoise noise) {
  return noise == CovarianceNoise::kStated ? "stated" : "residuals";
}

CovarianceNoise ParseCovarianceNoise(const std::string& name) {
  for (const CovarianceNoise noise : {CovarianceNoise::kStated, CovarianceNoise::kResiduals}) {
    if (name == Name(noise)) return noise;
  }
  throw UsageError("unknown covariance '" + name + "' (residuals, stated)");
}

GraphCovariance::GraphCovariance(const Graph& graph, const SolveOptions& options,
                                 const CovarianceOptions& covariance_options) {
  CheckGraph(graph);
  implementation_ = std::make_unique<Implementation>(graph, options, covariance_options);
}

GraphCovariance::~GraphCovariance() = default;

Matrix6d GraphCovariance::Pose(int pose) const {
  return implementation_->Covariance(PoseQuantity(pose));
}

Matrix6d GraphCovariance::Relative(int target, int source) const {
  return implementation_->Covariance(RelativeQuantity(implementation_->graph(), target, source));
}

MatrixXd GraphCovariance::Relatives(int target, const std::vector<int>& sources) const {
  std::vector<Quantity> quantities;
  quantities.reserve(sources.size());
  for (const int source : sources) {
    quantities.push_back(RelativeQuantity(implementation_->graph(), target, source));
  }
  return implementation_->JointCovariance(quantities);
}

Matrix7d GraphCovariance::Map(int map) const { return implementation_->MapCovariance(map); }

Matrix7d GraphCovariance::MapMean(const std::vector<std::pair<int, Matrix7d>>& by_maps) const {
  return implementation_->MeanOfMaps(by_maps);
}

double GraphCovariance::Scale(int scale) const { return implementation_->ScaleVariance(scale); }

Matrix3d GraphCovariance::Plane(int plane) const { return implementation_->PlaneCovariance(plane); }

std::vector<OpenMotion> GraphCovariance::OpenMotions() const {
  return implementation_->OpenMotions();
}

const CovarianceOptions& GraphCovariance::options() const { return implementation_->options(); }

std::vector<UnobservedDirection> GraphCovariance::Unobserved(int pose) const {
  return implementation_->Unobserved(PoseQuantity(pose));
}

std::vector<UnobservedDirection> GraphCovariance::UnobservedRelative(int target, int source) const {
  return implementation_->Unobserved(RelativeQuantity(implementation_->graph(), target, source));
}

}  // namespace planegraph
