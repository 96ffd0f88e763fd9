#include "planegraph/registration/icp.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "planegraph/cloud/filters.h"
#include "planegraph/cloud/kd_tree.h"
#include "planegraph/cloud/normals.h"

namespace planegraph {
namespace {

// Shares of variance: below, a neighbourhood is flat; above, scattered; between, an edge.
constexpr float kFlatShare = 0.02F;      // least of middle
constexpr float kScatteredShare = 0.2F;  // least of largest
// Pairs whose normal lies further than this from a direction (cosine) say nothing of it.
constexpr double kFacing = 0.3;
// Information must exceed what the normals' noise fakes by this factor (as in the closed form).
constexpr double kSpurious = 9.0;

enum class Shape { kFlat, kScattered, kEdge };

// A cloud thinned and made ready, in coordinates relative to its own offset.
struct Prepared {
  explicit Prepared(const Cloud& cloud, const IcpOptions& options)
      : thinned(VoxelFilter(cloud, options.voxel_size)),
        shapes(ComputeLocalShapes(thinned, options.neighbours)),
        tree(thinned.points) {}

  Shape ShapeAt(std::size_t i) const {
    const Eigen::Vector3f& v = shapes[i].variances;
    if (v[0] <= kFlatShare * v[1]) return Shape::kFlat;
    return v[0] > kScatteredShare * v[2] ? Shape::kScattered : Shape::kEdge;
  }
  // Variance of the normal's tilt, by the scatter of its neighbours.
  double TiltVariance(std::size_t i, std::size_t neighbours) const {
    const Eigen::Vector3f& v = shapes[i].variances;
    return v[0] / (std::max(v[1], 1e-12F) * static_cast<double>(neighbours));
  }

  Cloud thinned;
  std::vector<LocalShape> shapes;
  KdTree tree;
};

struct Pair {
  std::uint32_t source, target;
  Eigen::Vector3d apart;  // target - source, target's frame
  float squared_distance;
};

using Basis = Eigen::Matrix3Xd;

struct System {
  Eigen::MatrixXd information, spurious;
  Eigen::VectorXd right;
  double squares = 0.0, weight = 0.0;
  int pairs = 0;
  std::vector<Eigen::Vector3d> rows;  // unit
};

class TranslationIcp {
 public:
  TranslationIcp(const Cloud& target, const Cloud& source, const Rigid3& start,
                 const IcpOptions& options)
      : options_(options),
        target_(target, options),
        source_(source, options),
        rotation_(start.rotation.toRotationMatrix()),
        translation_(start.translation) {}

  IcpRefinement Run(const std::vector<Eigen::Vector3d>& directions);

 private:
  std::vector<Pair> FindPairs() const;
  bool Compatible(std::size_t source, std::size_t target) const;
  System Linearize(const std::vector<Pair>& pairs, const Basis& basis) const;
  void AddRow(const Pair& pair, const Eigen::Vector3d& row, double tilt_variance,
              const Basis& basis, System* system) const;
  Basis Observed(const System& system, const Basis& basis,
                 std::vector<Eigen::Vector3d>* featureless) const;
  Eigen::Vector3d Step(const Basis& observed) const;
  void Inform(const Basis& observed, IcpRefinement* result) const;

  const IcpOptions& options_;
  Prepared target_, source_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
};

bool TranslationIcp::Compatible(std::size_t source, std::size_t target) const {
  const Shape a = source_.ShapeAt(source), b = target_.ShapeAt(target);
  if (a != b || b == Shape::kEdge) return false;
  if (b == Shape::kScattered) return true;
  const Eigen::Vector3d turned = rotation_ * source_.shapes[source].normal.cast<double>();
  return turned.dot(target_.shapes[target].normal.cast<double>()) >=
         std::cos(options_.max_normal_angle_deg * std::numbers::pi / 180.0);
}

std::vector<Pair> TranslationIcp::FindPairs() const {
  std::vector<Pair> pairs;
  std::vector<KdTree::Neighbour> near;
  const float most = static_cast<float>(options_.first_gate * options_.first_gate);
  for (std::uint32_t i = 0; i < source_.thinned.size(); ++i) {
    const Eigen::Vector3d point =
        rotation_ * source_.thinned.Position(i) + translation_ - target_.thinned.offset;
    target_.tree.Nearest(point.cast<float>(), 1, &near);
    if (near.empty() || near[0].squared_distance > most) continue;
    if (!Compatible(i, near[0].index)) continue;
    pairs.push_back({i, near[0].index, target_.thinned.points[near[0].index].cast<double>() - point,
                     near[0].squared_distance});
  }
  if (pairs.empty()) return pairs;
  std::vector<float> squares;
  for (const Pair& p : pairs) squares.push_back(p.squared_distance);
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  const double median = std::max(options_.least_median, std::sqrt(static_cast<double>(*middle)));
  const auto limit = static_cast<float>(std::pow(options_.trim * median, 2));
  std::erase_if(pairs, [limit](const Pair& p) { return p.squared_distance > limit; });
  return pairs;
}

void TranslationIcp::AddRow(const Pair& pair, const Eigen::Vector3d& row, double tilt_variance,
                            const Basis& basis, System* system) const {
  // Its share along the open directions; what lies across them is not this row's business.
  const Eigen::VectorXd share = basis.transpose() * row;
  if (share.norm() < kFacing) return;
  const double residual = row.dot(pair.apart);
  system->information += share * share.transpose();
  system->spurious += tilt_variance * Eigen::MatrixXd::Identity(basis.cols(), basis.cols());
  system->right += residual * share;
  system->squares += residual * residual;
  system->rows.push_back(row);
  system->pairs++;
}

System TranslationIcp::Linearize(const std::vector<Pair>& pairs, const Basis& basis) const {
  System system;
  system.information = system.spurious = Eigen::MatrixXd::Zero(basis.cols(), basis.cols());
  system.right = Eigen::VectorXd::Zero(basis.cols());
  for (const Pair& pair : pairs) {
    if (target_.ShapeAt(pair.target) == Shape::kFlat) {
      AddRow(pair, target_.shapes[pair.target].normal.cast<double>(),
             target_.TiltVariance(pair.target, options_.neighbours), basis, &system);
    } else {
      for (int axis = 0; axis < 3; ++axis) {
        AddRow(pair, Eigen::Vector3d::Unit(axis), 0.0, basis, &system);
      }
    }
  }
  return system;
}

// The directions of the basis that enough pairs face and noise does not explain.
Basis TranslationIcp::Observed(const System& system, const Basis& basis,
                               std::vector<Eigen::Vector3d>* featureless) const {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(system.information);
  Basis observed(3, 0);
  for (Eigen::Index k = 0; k < basis.cols(); ++k) {
    const Eigen::VectorXd in_basis = eigen.eigenvectors().col(k);
    const Eigen::Vector3d v = basis * in_basis;
    const auto facing =
        std::count_if(system.rows.begin(), system.rows.end(),
                      [&v](const Eigen::Vector3d& row) { return std::abs(row.dot(v)) >= kFacing; });
    const double faked = in_basis.dot(system.spurious * in_basis);
    const bool known = static_cast<std::size_t>(facing) >= options_.least_pairs &&
                       eigen.eigenvalues()[k] > kSpurious * faked;
    if (!known) {
      featureless->push_back(v);
      continue;
    }
    observed.conservativeResize(3, observed.cols() + 1);
    observed.rightCols<1>() = v;
  }
  return observed;
}

Eigen::Vector3d TranslationIcp::Step(const Basis& observed) const {
  const System system = Linearize(FindPairs(), observed);
  if (system.pairs == 0) return Eigen::Vector3d::Zero();
  return observed * system.information.ldlt().solve(system.right);
}

void TranslationIcp::Inform(const Basis& observed, IcpRefinement* result) const {
  const System system = Linearize(FindPairs(), observed);
  result->pairs = system.pairs;
  if (system.pairs == 0) return;
  const double variance =
      std::max(system.squares / system.pairs, options_.least_sigma * options_.least_sigma);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(system.information / variance);
  const double most = 1.0 / (options_.least_sigma * options_.least_sigma);
  for (Eigen::Index k = 0; k < observed.cols(); ++k) {
    const Eigen::Vector3d v = observed * eigen.eigenvectors().col(k);
    result->information += std::min(eigen.eigenvalues()[k], most) * v * v.transpose();
  }
}

IcpRefinement TranslationIcp::Run(const std::vector<Eigen::Vector3d>& directions) {
  IcpRefinement result;
  result.translation = translation_;
  if (directions.empty()) return result;
  Basis basis(3, static_cast<Eigen::Index>(directions.size()));
  for (std::size_t k = 0; k < directions.size(); ++k) {
    basis.col(static_cast<Eigen::Index>(k)) = directions[k];
  }
  Basis observed = Observed(Linearize(FindPairs(), basis), basis, &result.featureless);
  while (observed.cols() > 0 && result.iterations < options_.max_iterations) {
    result.iterations++;
    const Eigen::Vector3d step = Step(observed);
    translation_ += step;
    result.converged = step.norm() < options_.stop;
    if (result.converged) break;
  }
  if (observed.cols() > 0) Inform(observed, &result);
  if (!result.featureless.empty()) {
    result.reason = "no information along " + std::to_string(result.featureless.size()) +
                    " of the open directions";
  } else if (!result.converged && observed.cols() > 0) {
    result.reason = "not converged";
  }
  result.translation = translation_;
  return result;
}

}  // namespace

IcpRefinement RefineTranslation(const Cloud& target, const Cloud& source,
                                const Rigid3& target_from_source,
                                const std::vector<Eigen::Vector3d>& open_directions,
                                const IcpOptions& options) {
  return TranslationIcp(target, source, target_from_source, options).Run(open_directions);
}

}  // namespace planegraph
