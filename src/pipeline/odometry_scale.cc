#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "planegraph/base/chi_square.h"
#include "planegraph/pipeline/chain.h"

namespace planegraph {
namespace {

// An orthonormal basis of the translations that a registration observes, one a column.
Eigen::MatrixXd ObservedTranslations(const Registration& registration) {
  Eigen::Matrix3d open = Eigen::Matrix3d::Zero();
  for (const UnobservedDirection& direction : registration.unobserved) {
    const Eigen::Vector3d translation = direction.direction.head<3>();
    open += translation * translation.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(open);
  const auto observed = (solver.eigenvalues().array() < 0.25).count();
  return solver.eigenvectors().leftCols(observed);
}

// Least squares for the one factor between the translations of steps and of registrations.
class ScaleFit {
 public:
  // Once for a robot, however many of its steps say so.
  void AddPrior(double sigma) {
    if (information_ > 0.0 || !(sigma > 0.0)) return;
    information_ = 1.0 / (sigma * sigma);
    weighted_ = information_;
  }

  void Add(const OdometryStep& step, const Registration& registration) {
    const Eigen::MatrixXd basis = ObservedTranslations(registration);
    if (basis.cols() == 0) return;
    const Matrix6d covariance = step.OwnCovariance() + registration.refinement.covariance;
    const auto ldlt = Projected(basis, covariance);
    const Eigen::VectorXd measured = basis.transpose() * step.target_from_source.translation;
    const Eigen::VectorXd found = basis.transpose() * registration.target_from_source().translation;
    const Eigen::VectorXd off = found - measured;
    if (!(Chi2(basis, step.covariance + registration.refinement.covariance, off) < most_)) return;
    const Eigen::VectorXd weighted = ldlt.solve(measured);
    information_ += measured.dot(weighted);
    weighted_ += found.dot(weighted);
  }

  // Steps without a common error (no prior) are what they are.
  double Scale() const { return information_ > 0.0 ? weighted_ / information_ : 1.0; }

 private:
  static Eigen::LDLT<Eigen::MatrixXd> Projected(const Eigen::MatrixXd& basis,
                                                const Matrix6d& covariance) {
    return Eigen::LDLT<Eigen::MatrixXd>(basis.transpose() * covariance.topLeftCorner<3, 3>() *
                                        basis);
  }

  static double Chi2(const Eigen::MatrixXd& basis, const Matrix6d& covariance,
                     const Eigen::VectorXd& off) {
    return off.dot(Projected(basis, covariance).solve(off));
  }

  // Beyond all chance: one in a million of good odometry.
  const double most_ = ChiSquareQuantile(1.0 - 1e-6, 3);
  double information_ = 0.0, weighted_ = 0.0;
};

}  // namespace

std::vector<double> ScaleOdometry(const std::vector<PairRecord>& chain, std::size_t robots,
                                  std::vector<OdometryStep>* steps) {
  std::vector<ScaleFit> fits(robots);
  for (const OdometryStep& step : *steps) fits[step.robot].AddPrior(step.sigma_scale);
  for (const PairRecord& pair : chain) {
    const OdometryStep* step = FindStep(*steps, pair);
    if (!pair.used || step == nullptr || !(step->sigma_scale > 0.0)) continue;
    fits[step->robot].Add(*step, pair.registration);
  }
  std::vector<double> scales;
  for (const ScaleFit& fit : fits) scales.push_back(fit.Scale());
  for (OdometryStep& step : *steps) step.Scale(scales[step.robot]);
  return scales;
}

}  // namespace planegraph
