// A plane eliminated from the problem by its own derivative (variable projection; of the kind of
// BALM, Liu and Zhang 2021, and the eigen-factors, Ferrer 2019; ALGORITHMS 6.5). One block of
// residuals for each plane over all poses and maps that see it: those of `moments` and
// `map_moments`,
//
//   r = [ r_i (T_i, n*, e*) ]        (n*, e*) = argmin of sum |r_i|^2 under the present poses
//
// Each residual is linear in x = (n, e), r = g(T) . x, so that (n*, e*) is the smallest eigenvector
// of Q = sum g g^T under |n| = 1, and its change with the poses follows from the bordered system
//
//   [ Q - l D   -D x ] [ dx ]     [ dQ x ]
//   [ (D x)^T     0  ] [ dl ] = - [  0   ]        D = diag(1, 1, 1, 0).
//
// So Gauss-Newton sees the curvature of the whole; the root of the smallest eigenvalue as one
// residual would hide all but one direction of it. The cost is that of `moments` minimized over the
// plane. A robust loss acts on the plane as a whole: on the sum of its k observations over k - 1.
#include <ceres/cost_function.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "planegraph/geometry/rotation.h"
#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/factor_sampling.h"
#include "planegraph/graph/manifolds.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Jacobian4 = Eigen::Matrix<double, 4, Eigen::Dynamic>;

// The three rows g of one observation (r = g . x), and the derivatives of each by the tangent of
// its node (4 x 6, or 4 x 7 for a map).
struct PlaneRows {
  std::array<Vector4d, 3> g;
  std::array<Jacobian4, 3> by_node;
  Vector3d facing;  // the measured normal, world: decides on the sign of the plane
};

Vector4d Extend(const Vector3d& v, double last) { return {v.x(), v.y(), v.z(), last}; }

template <typename View>
PlaneRows MakeRows(const View& node, const PlaneObservation& seen, const Vector3d& anchor) {
  constexpr int kTangent = View::kSize - 1;
  const Vector3d axis_1 = node.rotation * (seen.tilt_weight_1 * seen.axes.col(1));
  const Vector3d axis_2 = node.rotation * (seen.tilt_weight_2 * seen.axes.col(2));
  const Vector3d turned = node.scale * (node.rotation * seen.centroid);
  const double w = seen.offset_weight;
  PlaneRows rows;
  rows.facing = node.rotation * seen.axes.col(0);
  rows.g = {Extend(axis_1, 0.0), Extend(axis_2, 0.0), Extend(w * (turned + node.t - anchor), -w)};
  for (auto& by_node : rows.by_node) by_node = Jacobian4::Zero(4, kTangent);
  rows.by_node[0].block<3, 3>(0, 3) = -Hat(axis_1);
  rows.by_node[1].block<3, 3>(0, 3) = -Hat(axis_2);
  rows.by_node[2].block<3, 3>(0, 0) = w * Matrix3d::Identity();
  rows.by_node[2].block<3, 3>(0, 3) = -w * Hat(turned);
  if (kTangent == kMapTangent) rows.by_node[2].col(kTangent - 1) = Extend(w * turned, 0.0);
  return rows;
}

// The best plane x = (n, e) with |n| = 1, and the eigenvalue: the sum of squares that it leaves.
struct BestPlane {
  BestPlane(const Matrix4d& q, const Vector3d& facing) {
    const Vector3d coupling = q.topRightCorner<3, 1>() / q(3, 3);
    const Matrix3d reduced = q.topLeftCorner<3, 3>() - q(3, 3) * coupling * coupling.transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(reduced);
    Vector3d normal = solver.eigenvectors().col(0);
    if (normal.dot(facing) < 0.0) normal = -normal;
    x = Extend(normal, -coupling.dot(normal));
    eigenvalue = solver.eigenvalues()[0];
  }

  // The 4x4 matrix that takes -dQ x to dx.
  Matrix4d Response(const Matrix4d& q) const {
    const Vector4d normal = Extend(x.head<3>(), 0.0);
    Eigen::Matrix<double, 5, 5> bordered = Eigen::Matrix<double, 5, 5>::Zero();
    bordered.topLeftCorner<4, 4>() = q;
    bordered.topLeftCorner<3, 3>().diagonal().array() -= eigenvalue;
    bordered.topRightCorner<4, 1>() = -normal;
    bordered.bottomLeftCorner<1, 4>() = normal.transpose();
    return bordered.fullPivLu().inverse().topLeftCorner<4, 4>();
  }

  Vector4d x;
  double eigenvalue;
};

class EliminatedCost final : public ceres::CostFunction {
 public:
  EliminatedCost(std::vector<PlaneObservation> observations, const Vector3d& anchor)
      : observations_(std::move(observations)),
        anchor_(anchor),
        scale_(1.0 / std::sqrt(std::max(1.0, observations_.size() - 1.0))) {
    set_num_residuals(3 * static_cast<int>(observations_.size()));
    for (const PlaneObservation& seen : observations_) {
      mutable_parameter_block_sizes()->push_back(seen.map >= 0 ? kMapSize : kPoseSize);
    }
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    std::vector<PlaneRows> rows;
    Matrix4d q = Matrix4d::Zero();
    for (std::size_t k = 0; k < observations_.size(); ++k) {
      const PlaneObservation& seen = observations_[k];
      rows.push_back(seen.map >= 0 ? MakeRows(MapView(blocks[k]), seen, anchor_)
                                   : MakeRows(PoseView(blocks[k]), seen, anchor_));
      for (const Vector4d& g : rows.back().g) q += g * g.transpose();
    }
    if (!(q(3, 3) > 0.0) || !q.allFinite()) return false;
    const BestPlane plane(q, rows.front().facing);
    for (std::size_t a = 0; a < 3 * rows.size(); ++a) {
      residuals[a] = scale_ * rows[a / 3].g[a % 3].dot(plane.x);
    }
    if (jacobians == nullptr) return true;
    const Matrix4d response = plane.Response(q);
    for (std::size_t j = 0; j < rows.size(); ++j) {
      if (jacobians[j] != nullptr) WriteJacobian(rows, j, plane, response, blocks[j], jacobians[j]);
    }
    return true;
  }

 private:
  // Of all residuals by node j: through the plane, and those of the node's own also directly.
  void WriteJacobian(const std::vector<PlaneRows>& rows, std::size_t j, const BestPlane& plane,
                     const Matrix4d& response, const double* block, double* jacobian) const {
    const int tangent = static_cast<int>(rows[j].by_node[0].cols());
    Jacobian4 change = Jacobian4::Zero(4, tangent);  // dQ x
    for (int a = 0; a < 3; ++a) {
      const Vector4d& g = rows[j].g[a];
      change += g.dot(plane.x) * rows[j].by_node[a];
      change += g * (plane.x.transpose() * rows[j].by_node[a]);
    }
    const Jacobian4 plane_by_node = -response * change;
    for (std::size_t b = 0; b < rows.size(); ++b) {
      for (int a = 0; a < 3; ++a) {
        Eigen::RowVectorXd row = rows[b].g[a].transpose() * plane_by_node;
        if (b == j) row += plane.x.transpose() * rows[b].by_node[a];
        SetRow(scale_ * row, block, jacobian + (3 * b + a) * (tangent + 1));
      }
    }
  }

  static void SetRow(const Eigen::RowVectorXd& row, const double* block, double* out) {
    const Vector3d by_translation = row.head<3>(), by_rotation = row.segment<3>(3);
    if (row.size() == kMapTangent) {
      MapView(block).SetRow(by_translation, by_rotation, row[6], out);
    } else {
      PoseView(block).SetRow(by_translation, by_rotation, out);
    }
  }

  std::vector<PlaneObservation> observations_;
  Vector3d anchor_;
  double scale_;
};

// The observations of one node make one block: it may not appear twice in a residual.
std::vector<PlaneObservation> OnePerNode(const std::vector<PlaneObservation>& observations) {
  std::vector<PlaneObservation> kept;
  for (const PlaneObservation& seen : observations) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const PlaneObservation& other) {
      return seen.map >= 0 ? other.map == seen.map : other.map < 0 && other.pose == seen.pose;
    });
    if (!known) kept.push_back(seen);
  }
  return kept;
}

void AddPlane(const Graph& graph, int index, const FactorOptions&, ResidualSink* sink) {
  const PlaneLandmark& plane = graph.planes[index];
  std::vector<PlaneObservation> observations = OnePerNode(plane.observations);
  std::erase_if(observations, [](const auto& seen) { return !(seen.offset_weight > 0.0); });
  if (observations.size() < 2) return;  // a plane that one node sees holds nothing
  std::vector<BlockRef> blocks;
  for (const PlaneObservation& seen : observations) {
    blocks.push_back(seen.map >= 0 ? BlockRef{BlockKind::kMap, seen.map}
                                   : BlockRef{BlockKind::kPose, seen.pose});
  }
  const double weight = static_cast<double>(observations.size()) - 1.0;
  sink->Add(std::make_unique<EliminatedCost>(std::move(observations), plane.anchor),
            std::move(blocks), ResidualTag{.plane = index}, weight);
}

// Two to five nodes that see one plane, roughly: far from that the best plane jumps. Offsets are
// known in proportion to the scale: else rounding takes the digits of tilt or offset.
FactorSample Sample(std::mt19937_64* rng) {
  FactorSampler sampler(rng);
  const PlaneLandmark plane = sampler.Landmark();
  const auto basis = TangentBasis(plane.normal);
  const int count = 2 + static_cast<int>(sampler.Uniform(0.0, 4.0));
  FactorSample sample;
  std::vector<PlaneObservation> observations;
  for (int k = 0; k < count; ++k) {
    const bool is_map = sampler.Uniform(0.0, 1.0) < 0.3;
    Sim3 node = sampler.Map();
    if (!is_map) node.scale = 1.0;
    PlaneObservation seen = sampler.Observation(k);
    seen.map = is_map ? k : -1;
    seen.tilt_weight_1 = sampler.LogUniform(100.0, 1e4);
    seen.tilt_weight_2 = sampler.LogUniform(100.0, 1e4);
    seen.offset_weight = sampler.LogUniform(100.0, 1e4) / sampler.scale();
    Matrix3d axes;
    axes << plane.normal, basis;
    const Sim3 to_node = node.Inverse();
    seen.axes = to_node.rotation.toRotationMatrix() *
                ExpSO3(0.1 * sampler.UnitVector()).toRotationMatrix() * axes;
    const Vector3d in_plane = sampler.scale() * sampler.Uniform(0.5, 1.0) * sampler.UnitVector();
    seen.centroid = to_node * (plane.anchor + plane.offset * plane.normal + in_plane -
                               0.95 * plane.normal * plane.normal.dot(in_plane));
    observations.push_back(seen);
    sample.kinds.push_back(is_map ? BlockKind::kMap : BlockKind::kPose);
    sample.values.push_back(is_map ? FactorSampler::Block(node)
                                   : FactorSampler::Block(Rigid3(node.rotation, node.translation)));
    const double distance = (node * seen.centroid - plane.anchor).norm();
    sample.length = std::max(sample.length, 0.01 * distance);
  }
  sample.cost = std::make_unique<EliminatedCost>(std::move(observations), plane.anchor);
  return sample;
}

}  // namespace

void Register_eliminated(FactorRegistry* registry) {
  FactorType type;
  type.name = "eliminated";
  type.kind = FactorKind::kPlane;
  type.description = "all poses and maps that see a plane, the plane eliminated by its derivative";
  type.residual =
      "for each of a plane's k observations the residuals of `moments` against the best plane, "
      "over "
      "sqrt(k - 1); weight k - 1, a robust loss acts on the plane as a whole";
  type.parameters = {
      {"tilt_weight_1", "1/rad", "inverse sigma of the tilt along in-plane axis 1", 1.0, true},
      {"tilt_weight_2", "1/rad", "inverse sigma of the tilt along in-plane axis 2", 1.0, true},
      {"offset_weight", "1/m", "inverse sigma of the offset at the centroid, world", 1.0, true}};
  type.map_counterpart = type.name;
  type.linearized_as = "moments";
  type.add_plane = AddPlane;
  type.sample = Sample;
  registry->Add(std::move(type));
}

}  // namespace planegraph
