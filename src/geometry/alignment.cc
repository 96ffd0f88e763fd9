#include "planegraph/geometry/alignment.h"

#include <Eigen/SVD>

namespace planegraph {
namespace {

Eigen::Vector3d Mean(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

// Singular values below this share of the largest are noise of the positions' last digits.
constexpr double kRankTolerance = 1e-9;

}  // namespace

Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target, bool with_scale) {
  const Eigen::Vector3d source_mean = Mean(source), target_mean = Mean(target);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double source_square = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    covariance += (target[i] - target_mean) * (source[i] - source_mean).transpose();
    source_square += (source[i] - source_mean).squaredNorm();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& singular = svd.singularValues();
  const double determinant = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Vector3d signs(1.0, 1.0, determinant < 0 ? -1.0 : 1.0);
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  Alignment result;
  result.rank =
      static_cast<int>((singular.array() > kRankTolerance * std::max(singular[0], 1e-300)).count());
  const bool scalable = with_scale && source_square > 0;
  const double scale = scalable ? singular.dot(signs) / source_square : 1.0;
  result.target_from_source = Sim3(scale, Eigen::Quaterniond(rotation).normalized(),
                                   target_mean - scale * (rotation * source_mean));
  return result;
}

}  // namespace planegraph
