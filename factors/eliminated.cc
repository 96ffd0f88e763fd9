// A plane eliminated from the problem by its own derivative (variable projection; of the kind of
// BALM, Liu and Zhang 2021, and the eigen-factors, Ferrer 2019; ALGORITHMS 6.5). One block of
// residuals for each plane over all poses and maps that see it: those of `moments` and
// `map_moments`,
//
//   r = [ r_i (T_i, n*, e*) ]        (n*, e*) = argmin of sum |r_i|^2 under the present poses
//
// Each residual is linear in x = (n, e), r = G x. With the offset at its best for a given n, which
// is that of the weighted mean of the centroids, r = A n is left: n* is the last right singular
// vector of A = U S V^T (not the eigenvector of A^T A, which has half of the digits), and
//
//   dr = (I - o o^T) dG x - sum_k u_k [s_k^2 u_k . dG x + s_k v_k . dG^T r] / (s_k^2 - s_3^2)
//
// over k = 1, 2, with o the unit vector of the offsets' weights. o, u_1, u_2 are orthonormal: what
// a node's move and the plane's answer to it cancel of each other is lost without loss of digits.
//
// So Gauss-Newton sees the curvature of the whole; the root of the smallest eigenvalue as one
// residual would hide all but one direction of it. The cost is that of `moments` minimized over the
// plane. A robust loss acts on the plane as a whole: on the sum of its k observations over k - 1.
#include <ceres/cost_function.h>

#include <Eigen/SVD>
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

using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// The best plane x = (n, e) with |n| = 1, and what its answer to the nodes' moves follows from.
struct BestPlane {
  explicit BestPlane(const std::vector<PlaneRows>& rows) : offsets(3 * rows.size()) {
    Vector3d mean = Vector3d::Zero();
    for (Eigen::Index a = 0; a < offsets.size(); ++a) offsets[a] = -rows[a / 3].g[a % 3][3];
    const double information = offsets.squaredNorm();
    for (Eigen::Index a = 0; a < offsets.size(); ++a) {
      mean += offsets[a] / information * rows[a / 3].g[a % 3].head<3>();
    }
    Rows3 reduced(offsets.size(), 3);
    for (Eigen::Index a = 0; a < offsets.size(); ++a) {
      reduced.row(a) = rows[a / 3].g[a % 3].head<3>() - offsets[a] * mean;
    }
    offsets /= std::sqrt(information);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(reduced, Eigen::ComputeThinU | Eigen::ComputeThinV);
    u = svd.matrixU();
    v = svd.matrixV();
    s = svd.singularValues();
    const double side = v.col(2).dot(rows.front().facing) < 0.0 ? -1.0 : 1.0;
    x = Extend(side * v.col(2), mean.dot(side * v.col(2)));
    residual = side * s[2] * u.col(2);
  }

  Vector4d x;
  Eigen::VectorXd offsets;  // unit vector of the offsets' weights
  Eigen::VectorXd residual;
  Rows3 u;
  Matrix3d v;
  Vector3d s;
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
    const std::vector<PlaneRows> rows = MakeAllRows(blocks);
    const BestPlane plane(rows);
    if (!plane.x.allFinite() || !plane.residual.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = scale_ * plane.residual;
    if (jacobians == nullptr) return true;
    for (std::size_t j = 0; j < rows.size(); ++j) {
      if (jacobians[j] != nullptr) WriteJacobian(rows[j], j, plane, blocks[j], jacobians[j]);
    }
    return true;
  }

  // How much of the digits a node's turn and the plane's answer to it cancel: the largest change of
  // an offset by radian of a turn over the second singular value, the stiffness against tilts.
  double Stiffness(double const* const* blocks) const {
    const std::vector<PlaneRows> rows = MakeAllRows(blocks);
    double largest = 0.0;
    for (const PlaneRows& r : rows) {
      largest = std::max(largest, r.by_node[2].topRows<3>().norm());
    }
    return largest / BestPlane(rows).s[1];
  }

 private:
  std::vector<PlaneRows> MakeAllRows(double const* const* blocks) const {
    std::vector<PlaneRows> rows;
    for (std::size_t k = 0; k < observations_.size(); ++k) {
      const PlaneObservation& seen = observations_[k];
      rows.push_back(seen.map >= 0 ? MakeRows(MapView(blocks[k]), seen, anchor_)
                                   : MakeRows(PoseView(blocks[k]), seen, anchor_));
    }
    return rows;
  }

  // Of all residuals by node j: through the plane, and those of the node's own also directly.
  void WriteJacobian(const PlaneRows& rows, std::size_t j, const BestPlane& plane,
                     const double* block, double* jacobian) const {
    const Eigen::Index first = 3 * static_cast<Eigen::Index>(j), size = rows.by_node[0].cols();
    Eigen::MatrixXd direct(3, size);                            // dG x
    Eigen::MatrixXd on_plane = Eigen::MatrixXd::Zero(3, size);  // dG^T r
    for (int a = 0; a < 3; ++a) {
      direct.row(a) = plane.x.transpose() * rows.by_node[a];
      on_plane += plane.residual[first + a] * rows.by_node[a].topRows<3>();
    }
    Eigen::MatrixXd change =
        -plane.offsets * (plane.offsets.segment<3>(first).transpose() * direct);
    for (int k = 0; k < 2; ++k) {
      const double s = plane.s[k], gap = (s - plane.s[2]) * (s + plane.s[2]);
      change -= plane.u.col(k) * (s * s / gap * plane.u.block<3, 1>(first, k).transpose() * direct +
                                  s / gap * plane.v.col(k).transpose() * on_plane);
    }
    change.middleRows<3>(first) += direct;
    for (Eigen::Index row = 0; row < change.rows(); ++row) {
      SetRow(scale_ * change.row(row), block, jacobian + row * (size + 1));
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
  blocks.reserve(observations.size());
  for (const PlaneObservation& seen : observations) {
    blocks.push_back(seen.map >= 0 ? BlockRef{BlockKind::kMap, seen.map}
                                   : BlockRef{BlockKind::kPose, seen.pose});
  }
  const double weight = static_cast<double>(observations.size()) - 1.0;
  sink->Add(std::make_unique<EliminatedCost>(std::move(observations), plane.anchor),
            std::move(blocks), ResidualTag{.plane = index}, weight);
}

// Two to five nodes and what they see, of one plane or not.
std::unique_ptr<EliminatedCost> DrawSample(std::mt19937_64* rng, FactorSample* sample) {
  FactorSampler sampler(rng);
  const PlaneLandmark plane = sampler.Landmark();
  const int count = 2 + static_cast<int>(sampler.Uniform(0.0, 4.0));
  std::vector<PlaneObservation> observations;
  for (int k = 0; k < count; ++k) {
    PlaneObservation& seen = observations.emplace_back(sampler.Observation(k));
    seen.map = sampler.Uniform(0.0, 1.0) < 0.3 ? k : -1;
    sample->kinds.push_back(seen.map >= 0 ? BlockKind::kMap : BlockKind::kPose);
    sample->values.push_back(seen.map >= 0 ? FactorSampler::Block(sampler.Map())
                                           : FactorSampler::Block(sampler.Pose()));
  }
  return std::make_unique<EliminatedCost>(std::move(observations), plane.anchor);
}

// Not in the factor's domain is one draw in a hundred: a plane that is hardly held against tilts
// answers to a node whose turn is known kStiffest times better, such as 0.1 mm at a kilometre
// against a degree. Of the move and the answer, which cancel but for the inverse square of that,
// there are then too few digits left to test a Jacobian by.
FactorSample Sample(std::mt19937_64* rng) {
  constexpr double kStiffest = 1e4;
  for (;;) {
    FactorSample sample;
    auto cost = DrawSample(rng, &sample);
    std::vector<const double*> blocks;
    for (const auto& value : sample.values) blocks.push_back(value.data());
    if (cost->Stiffness(blocks.data()) > kStiffest) continue;
    sample.cost = std::move(cost);
    return sample;
  }
}

}  // namespace

void Register_eliminated(FactorRegistry* registry) {
  FactorType type;
  type.name = "eliminated";
  type.kind = FactorKind::kPlane;
  type.description = "all poses and maps that see a plane, the plane eliminated by its derivative";
  type.source =
      "variable projection, Golub and Pereyra 1973; of the kind of BALM (Liu and Zhang, RA-L 2021) "
      "and eigen-factors (Ferrer, IROS 2019); own derivative";
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
