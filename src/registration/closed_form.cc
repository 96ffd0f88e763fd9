#include "planegraph/registration/closed_form.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// Variance that stands for "nothing is known": a kilometre, or a thousand radians.
constexpr double kUnheldVariance = 1e6;
// Share of the largest singular value below which a rotation is free.
constexpr double kFree = 1e-9;

// Inverse of a symmetric positive semidefinite matrix whose null space gets kUnheldVariance.
Eigen::Matrix3d InverseOrNothing(const Eigen::Matrix3d& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(information);
  const double least = std::max(1e-12 * eigen.eigenvalues()[2], 1.0 / kUnheldVariance);
  Eigen::Vector3d variances;
  for (int k = 0; k < 3; ++k) {
    variances[k] = eigen.eigenvalues()[k] > least ? 1.0 / eigen.eigenvalues()[k] : kUnheldVariance;
  }
  return eigen.eigenvectors() * variances.asDiagonal() * eigen.eigenvectors().transpose();
}

double RotationWeight(const PlaneMatch& m) {
  return 1.0 / std::max(m.target.TiltVariance() + m.source.TiltVariance(), 1e-18);
}

// Information of the normals on the rotation, by the mean of both normals of each match.
Eigen::Matrix3d NormalInformation(const std::vector<PlaneMatch>& matches,
                                  const Eigen::Quaterniond& rotation) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PlaneMatch& m : matches) {
    const Eigen::Vector3d n = (m.target.normal + rotation * m.source.normal).normalized();
    sum += RotationWeight(m) * (Eigen::Matrix3d::Identity() - n * n.transpose());
  }
  return sum;
}

// One row n . (R c_source + t - c_target) = 0 of the translation's system.
struct Row {
  Eigen::Vector3d normal;
  Eigen::Vector3d arm;    // R c_source
  double value;           // normal . (c_target - arm), so that normal . t = value
  double variance = 0.0;  // of the row but for the rotation, m^2
  double weight = 0.0;    // 1 / (variance and the rotation's share)
  Eigen::Matrix3d tilt;   // covariance of the normal
};

class TranslationSystem {
 public:
  TranslationSystem(const std::vector<PlaneMatch>& matches, const RotationSolution& rotation);

  // Weights for centroids that lie as far apart as this translation puts them.
  void Weigh(const Eigen::Vector3d& translation);
  TranslationSolution Solve(const ClosedFormOptions& options,
                            const std::optional<TranslationPrior>& prior) const;

 private:
  int Rank(const TranslationSolution& solution, const ClosedFormOptions& options,
           const std::optional<TranslationPrior>& prior) const;
  double Spurious(const Eigen::Vector3d& direction) const;
  void Truncate(const std::optional<TranslationPrior>& prior, TranslationSolution* solution) const;
  void Soften(const TranslationPrior& prior, TranslationSolution* solution) const;
  Eigen::Matrix3d RowNoise() const;
  Eigen::Matrix3d RotationEffect() const;

  const std::vector<PlaneMatch>& matches_;
  const RotationSolution& rotation_;
  std::vector<Row> rows_;
  std::vector<Eigen::Vector3d> levers_;  // of the rows about the middle of all centroids
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

TranslationSystem::TranslationSystem(const std::vector<PlaneMatch>& matches,
                                     const RotationSolution& rotation)
    : matches_(matches), rotation_(rotation) {
  const Eigen::Matrix3d r = rotation.target_from_source.toRotationMatrix();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PlaneMatch& m : matches) {
    Row row;
    row.normal = (m.target.normal + r * m.source.normal).normalized();
    row.arm = r * m.source.centroid;
    row.value = row.normal.dot(m.target.centroid - row.arm);
    row.tilt = 0.25 * (m.target.normal_covariance + r * m.source.normal_covariance * r.transpose());
    rows_.push_back(row);
    middle += 0.5 * (row.arm + m.target.centroid) / static_cast<double>(matches.size());
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    levers_.push_back(0.5 * (rows_[i].arm + matches[i].target.centroid) - middle);
  }
}

void TranslationSystem::Weigh(const Eigen::Vector3d& translation) {
  information_.setZero();
  right_.setZero();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    const Eigen::Vector3d apart = row.arm + translation - matches_[i].target.centroid;
    row.variance = matches_[i].target.offset_variance + matches_[i].source.offset_variance +
                   apart.dot(row.tilt * apart);
    const Eigen::Vector3d turn = levers_[i].cross(row.normal);
    // Turns that nothing is known of are the rotation's problem, not this row's.
    const double turned = std::min(turn.dot(rotation_.covariance * turn), 1.0);
    row.weight = 1.0 / (row.variance + turned);
    information_ += row.weight * row.normal * row.normal.transpose();
    right_ += row.weight * row.value * row.normal;
  }
}

double TranslationSystem::Spurious(const Eigen::Vector3d& direction) const {
  double sum = 0.0;
  for (const Row& row : rows_) sum += row.weight * direction.dot(row.tilt * direction);
  return sum;
}

int TranslationSystem::Rank(const TranslationSolution& solution, const ClosedFormOptions& options,
                            const std::optional<TranslationPrior>& prior) const {
  int rank = 0;
  for (; rank < 3; ++rank) {
    const Eigen::Vector3d v = solution.directions.col(rank);
    double most = options.most_sigma;
    if (prior) most = std::min(most, std::sqrt(v.dot(prior->covariance * v)));
    const double information = std::pow(solution.singular_values[rank], 2);
    if (information * most * most <= 1.0) break;
    if (information <= options.spurious_factor * Spurious(v)) break;
  }
  return rank;
}

// sum w^2 variance n n^T: what the rows' own noise does, less the rotation's share in the weights.
Eigen::Matrix3d TranslationSystem::RowNoise() const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Row& row : rows_) {
    sum += row.weight * row.weight * row.variance * row.normal * row.normal.transpose();
  }
  return sum;
}

Eigen::Matrix3d TranslationSystem::RotationEffect() const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Row& row : rows_) {
    sum -= row.weight * row.normal * row.arm.cross(row.normal).transpose();
  }
  return sum;
}

void TranslationSystem::Truncate(const std::optional<TranslationPrior>& prior,
                                 TranslationSolution* solution) const {
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero(), open = Eigen::Matrix3d::Identity();
  for (int k = 0; k < solution->rank; ++k) {
    const Eigen::Vector3d v = solution->directions.col(k);
    inverse += v * v.transpose() / std::pow(solution->singular_values[k], 2);
    open -= v * v.transpose();
  }
  const Eigen::Matrix3d held =
      prior ? prior->covariance : kUnheldVariance * Eigen::Matrix3d::Identity();
  solution->translation = inverse * right_;
  if (prior) solution->translation += open * prior->translation;
  solution->covariance = inverse * RowNoise() * inverse + open * held * open;
  solution->sensitivity = inverse * RotationEffect();
}

void TranslationSystem::Soften(const TranslationPrior& prior, TranslationSolution* solution) const {
  const Eigen::Matrix3d known = prior.covariance.inverse();
  const Eigen::Matrix3d inverse = (information_ + known).inverse();
  solution->translation = inverse * (right_ + known * prior.translation);
  solution->covariance = inverse * (RowNoise() + known) * inverse;
  solution->sensitivity = inverse * RotationEffect();
}

TranslationSolution TranslationSystem::Solve(const ClosedFormOptions& options,
                                             const std::optional<TranslationPrior>& prior) const {
  TranslationSolution solution;
  Eigen::MatrixX3d whitened = Eigen::MatrixX3d::Zero(std::max<Eigen::Index>(rows_.size(), 3), 3);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    whitened.row(static_cast<Eigen::Index>(i)) =
        std::sqrt(rows_[i].weight) * rows_[i].normal.transpose();
  }
  const Eigen::JacobiSVD<Eigen::MatrixX3d> svd(whitened, Eigen::ComputeFullV);
  solution.directions = svd.matrixV();
  solution.singular_values.setZero();
  solution.singular_values.head(svd.singularValues().size()) = svd.singularValues();
  solution.rank = Rank(solution, options, prior);
  if (prior && options.open == OpenDirections::kSoftPrior) {
    Soften(*prior, &solution);
  } else {
    Truncate(prior, &solution);
  }
  return solution;
}

UnobservedDirection MakeOpen(int first, const Eigen::Vector3d& axis, const Matrix6d& covariance,
                             const std::string& held_by) {
  UnobservedDirection open;
  open.direction.setZero();
  open.direction.segment<3>(first) = axis;
  const double variance = open.direction.dot(covariance * open.direction);
  const bool held = variance < 0.01 * kUnheldVariance;
  open.sigma = held ? std::sqrt(variance) : std::numeric_limits<double>::quiet_NaN();
  if (held) open.held_by = held_by;
  return open;
}

// Axes of rotation that the normals alone leave open.
std::vector<Eigen::Vector3d> OpenAxes(const Eigen::Matrix3d& information, double limit) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(information);
  std::vector<Eigen::Vector3d> axes;
  for (int k = 0; k < 3; ++k) {
    if (eigen.eigenvalues()[k] * limit * limit <= 1.0)
      axes.emplace_back(eigen.eigenvectors().col(k));
  }
  return axes;
}

}  // namespace

FittedPlane MakeFittedPlane(const PlaneSegment& segment) {
  const Eigen::Vector3d a = segment.axes.vectors.col(1), b = segment.axes.vectors.col(2);
  return {
      segment.plane.normal, segment.centroid(),
      segment.covariance(0, 0) * a * a.transpose() + segment.covariance(1, 1) * b * b.transpose(),
      segment.covariance(2, 2)};
}

RotationSolution SolveRotation(const std::vector<PlaneMatch>& matches,
                               const std::optional<RotationPrior>& prior) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PlaneMatch& m : matches) {
    sum += RotationWeight(m) * m.target.normal * m.source.normal.transpose();
  }
  const double known = prior ? 1.0 / (prior->sigma * prior->sigma) : 0.0;
  if (prior) sum += 0.5 * known * prior->target_from_source.toRotationMatrix();
  RotationSolution solution;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d s = svd.singularValues();
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant();
  solution.uniqueness = s[0] > 0 ? (s[1] + (sign < 0 ? -s[2] : s[2])) / s[0] : 0.0;
  solution.unique = solution.uniqueness > kFree;
  if (!solution.unique) sum += std::max(kFree * s[0], 1e-12) * Eigen::Matrix3d::Identity();
  solution.target_from_source = Eigen::Quaterniond(ProjectToRotation(sum)).normalized();
  solution.information =
      known * Eigen::Matrix3d::Identity() + NormalInformation(matches, solution.target_from_source);
  solution.covariance = InverseOrNothing(solution.information);
  return solution;
}

TranslationSolution SolveTranslation(const std::vector<PlaneMatch>& matches,
                                     const RotationSolution& rotation,
                                     const ClosedFormOptions& options,
                                     const std::optional<TranslationPrior>& prior) {
  TranslationSystem system(matches, rotation);
  // The distance of the centroids counts in the weights, and follows from the translation.
  Eigen::Vector3d mean_apart = Eigen::Vector3d::Zero();
  for (const PlaneMatch& m : matches) {
    mean_apart += (m.target.centroid - rotation.target_from_source * m.source.centroid) /
                  static_cast<double>(matches.size());
  }
  system.Weigh(prior ? prior->translation : mean_apart);
  system.Weigh(system.Solve(options, prior).translation);
  return system.Solve(options, prior);
}

ClosedFormPose SolveClosedForm(const std::vector<PlaneMatch>& matches,
                               const ClosedFormOptions& options,
                               const std::optional<PosePrior>& prior, const std::string& held_by) {
  std::optional<RotationPrior> rotation_prior;
  std::optional<TranslationPrior> translation_prior;
  if (prior) {
    const double variance = prior->covariance.bottomRightCorner<3, 3>().trace() / 3.0;
    rotation_prior = {prior->target_from_source.rotation, std::sqrt(variance)};
    translation_prior = {prior->target_from_source.translation,
                         prior->covariance.topLeftCorner<3, 3>()};
  }
  const RotationSolution rotation = SolveRotation(matches, rotation_prior);
  const TranslationSolution translation =
      SolveTranslation(matches, rotation, options, translation_prior);
  ClosedFormPose pose;
  pose.target_from_source = {rotation.target_from_source, translation.translation};
  pose.rank = translation.rank;
  pose.unique_rotation = rotation.unique;
  const Eigen::Matrix3d cross = translation.sensitivity * rotation.covariance;
  pose.covariance << translation.covariance + cross * translation.sensitivity.transpose(), cross,
      cross.transpose(), rotation.covariance;
  for (int k = translation.rank; k < 3; ++k) {
    pose.unobserved.push_back(MakeOpen(0, translation.directions.col(k), pose.covariance, held_by));
  }
  const Eigen::Matrix3d by_planes = NormalInformation(matches, rotation.target_from_source);
  for (const auto& axis : OpenAxes(by_planes, options.weak_rotation)) {
    pose.unobserved.push_back(MakeOpen(3, axis, pose.covariance, held_by));
  }
  return pose;
}

}  // namespace planegraph
