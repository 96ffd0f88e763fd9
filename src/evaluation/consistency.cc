#include "planegraph/evaluation/consistency.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "planegraph/base/chi_square.h"

namespace planegraph {
namespace {

constexpr double kBand = 0.95;

std::vector<Eigen::Index> UsableRows(const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    if (std::isfinite(covariance(k, k)) && covariance(k, k) > 0.0) rows.push_back(k);
  }
  return rows;
}

Eigen::VectorXd Stacked(const std::vector<Eigen::VectorXd>& errors) {
  Eigen::Index size = 0;
  for (const Eigen::VectorXd& error : errors) size += error.size();
  Eigen::VectorXd all(size);
  Eigen::Index at = 0;
  for (const Eigen::VectorXd& error : errors) {
    all.segment(at, error.size()) = error;
    at += error.size();
  }
  return all;
}

void SetAll(const std::vector<Eigen::VectorXd>& errors, const Eigen::MatrixXd& joint,
            Consistency* consistency) {
  for (const NormalizedError& one : consistency->each) {
    consistency->all.squared += one.squared;
    consistency->all.degrees += one.degrees;
  }
  consistency->joint = errors.size() == 1;
  if (joint.size() > 0) {
    const auto all = Normalize(Stacked(errors), joint);
    if (all) consistency->all = *all;
    consistency->joint = all.has_value();
  }
  if (!consistency->joint) return;
  const int degrees = consistency->all.degrees;
  consistency->band = {ChiSquareQuantile(0.5 - 0.5 * kBand, degrees) / degrees,
                       ChiSquareQuantile(0.5 + 0.5 * kBand, degrees) / degrees};
}

}  // namespace

std::optional<NormalizedError> Normalize(const Eigen::VectorXd& error,
                                         const Eigen::MatrixXd& covariance) {
  const std::vector<Eigen::Index> rows = UsableRows(covariance);
  if (rows.empty()) return std::nullopt;
  // Metres beside radians, millimetres beside metres: judged after scaling to unit diagonal.
  const Eigen::MatrixXd used = covariance(rows, rows);
  const Eigen::VectorXd scale = used.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> cholesky(scale.asDiagonal() * used * scale.asDiagonal());
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd scaled = scale.cwiseProduct(Eigen::VectorXd(error(rows)));
  const double squared = cholesky.matrixL().solve(scaled).squaredNorm();
  if (!std::isfinite(squared)) return std::nullopt;
  return NormalizedError{squared, static_cast<int>(rows.size())};
}

std::array<double, 3> Coverage(const std::vector<NormalizedError>& errors) {
  std::array<double, 3> shares = {};
  for (std::size_t k = 0; k < shares.size(); ++k) {
    int inside = 0;
    for (const NormalizedError& error : errors) {
      inside += ChiSquareTail(error.squared, error.degrees) >= 1.0 - kCoverageLevels[k] ? 1 : 0;
    }
    shares[k] = inside / static_cast<double>(errors.size());
  }
  return shares;
}

std::optional<Consistency> MeasureConsistency(const std::vector<Eigen::VectorXd>& errors,
                                              const std::vector<Eigen::MatrixXd>& covariances,
                                              const Eigen::MatrixXd& joint) {
  Consistency consistency;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const auto one = Normalize(errors[i], covariances[i]);
    if (one) consistency.each.push_back(*one);
  }
  if (consistency.each.empty()) return std::nullopt;
  consistency.coverage = Coverage(consistency.each);
  SetAll(errors, joint, &consistency);
  return consistency;
}

}  // namespace planegraph
