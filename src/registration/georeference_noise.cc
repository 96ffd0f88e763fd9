#include "registration/georeference_noise.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "registration/georeference_rows.h"

namespace planegraph {
namespace {

// Columns of the linear system: seven of the similarity, the time, and the residual.
constexpr int kTime = 7, kResidual = 8, kColumns = 9;
using Gram = Eigen::Matrix<double, kColumns, kColumns>;
using AxisRows = Eigen::Matrix<double, 3, kColumns>;

// The linear system of one linearization.
struct LinearSystem {
  std::vector<AxisRows> rows;
  std::vector<double> times;
  int parameters = 7;
};

// Share and time of the correlated part.
struct Correlation {
  double share = 0.0, time = 1.0, prior = 0.0;
};

// The system whitened by a correlation: sums over the horizontal axes and the vertical one.
struct WhitenedSystem {
  Gram horizontal = Gram::Zero(), vertical = Gram::Zero();
  double log_determinant = 0.0;  // of one axis's correlation matrix
};

// One set of noise parameters with what follows from it.
struct Candidate {
  double log_weight = 0.0;
  double variance = 0.0, ratio = 1.0;  // of a horizontal axis; standard deviations' ratio
  Eigen::VectorXd step;
  Eigen::MatrixXd covariance;
};

std::vector<Correlation> CorrelationGrid(const CorrelationOptions& options) {
  constexpr double kWhitePrior = 0.25;
  if (!options.correlated) return {{0.0, 1.0, 1.0}};
  const std::vector<double> shares = {0.3, 0.5, 0.7, 0.85, 0.95};
  const std::vector<double> times = options.in_seconds
                                        ? std::vector<double>{1, 2.5, 5, 10, 20, 40, 80}
                                        : std::vector<double>{1.5, 3, 6, 12};
  std::vector<Correlation> grid = {{0.0, 1.0, kWhitePrior}};
  const double prior = (1.0 - kWhitePrior) / static_cast<double>(shares.size() * times.size());
  for (const double share : shares) {
    for (const double time : times) grid.push_back({share, time, prior});
  }
  return grid;
}

struct Ratio {
  double value = 1.0, log_prior = 0.0;
};

// Log-normal about the usual ratio.
std::vector<Ratio> RatioGrid(const NoisePrior& prior) {
  constexpr double kSpread = 0.5;
  if (!prior.vertical_differs) return {{1.0, 0.0}};
  std::vector<Ratio> grid;
  for (const double value : {0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6}) {
    const double deviation = std::log(value / prior.vertical_ratio()) / kSpread;
    grid.push_back({value, -0.5 * deviation * deviation});
  }
  return grid;
}

LinearSystem Linearize(const std::vector<PositionPair>& pairs, const SimilarityRows& rows,
                       bool with_time) {
  LinearSystem system;
  system.parameters = with_time ? 8 : 7;
  for (const auto& pair : pairs) {
    const auto row = rows.Of(pair);
    AxisRows axes = AxisRows::Zero();
    axes.leftCols<7>() = row.jacobian;
    axes.col(kTime) = -pair.velocity;
    axes.col(kResidual) = row.residual;
    system.rows.push_back(axes);
    system.times.push_back(pair.time);
  }
  return system;
}

// A Kalman filter for the correlated part, run over all columns at once: its innovations are the
// rows whitened by the inverse Cholesky factor of the correlation matrix, in linear time.
WhitenedSystem Whiten(const LinearSystem& system, const Correlation& correlation) {
  WhitenedSystem whitened;
  AxisRows predicted = AxisRows::Zero();
  double variance = correlation.share;
  for (std::size_t k = 0; k < system.rows.size(); ++k) {
    const double gap = k > 0 ? system.times[k] - system.times[k - 1] : 0.0;
    const double decay = std::exp(-gap / correlation.time);
    predicted *= decay;
    variance = decay * decay * variance + correlation.share * (1.0 - decay * decay);
    const double total = variance + (1.0 - correlation.share);
    const AxisRows innovation = system.rows[k] - predicted;
    predicted += variance / total * innovation;
    variance *= 1.0 - variance / total;
    const auto top = innovation.topRows<2>();
    whitened.horizontal += top.transpose() * top / total;
    whitened.vertical += innovation.row(2).transpose() * innovation.row(2) / total;
    whitened.log_determinant += std::log(total);
  }
  return whitened;
}

// Student's distribution has a larger variance than the normal one of the same scale.
double StudentFactor(double freedom) {
  constexpr double kLargest = 10.0;
  return freedom > 2.0 ? std::min(freedom / (freedom - 2.0), kLargest) : kLargest;
}

Candidate Evaluate(const LinearSystem& system, const WhitenedSystem& whitened, const Ratio& ratio,
                   double least_variance) {
  const Gram gram = whitened.horizontal + whitened.vertical / (ratio.value * ratio.value);
  const int p = system.parameters;
  const double count = static_cast<double>(system.rows.size());
  Eigen::MatrixXd normal = gram.topLeftCorner(p, p);
  Matrix7d similarity = normal.topLeftCorner<7, 7>();
  Damp(&similarity);
  normal.topLeftCorner<7, 7>() = similarity;
  if (p > kTime) normal(kTime, kTime) += 1e-12;  // a camera at rest says nothing of the time
  const Eigen::LLT<Eigen::MatrixXd> cholesky(normal);
  Candidate result;
  result.ratio = ratio.value;
  const Eigen::VectorXd right = gram.col(kResidual).head(p);
  result.step = -cholesky.solve(right);
  const double squares = gram(kResidual, kResidual) + right.dot(result.step);
  const double freedom = std::max(3.0 * count - p, 1.0);
  result.variance = std::max(squares / freedom, least_variance);
  result.covariance =
      result.variance * StudentFactor(freedom) * cholesky.solve(Eigen::MatrixXd::Identity(p, p));
  const double log_normal = 2.0 * cholesky.matrixLLT().diagonal().array().log().sum();
  result.log_weight = ratio.log_prior -
                      0.5 * (freedom * std::log(result.variance) + 3.0 * whitened.log_determinant +
                             2.0 * count * std::log(ratio.value) + log_normal);
  return result;
}

// The candidates' mean and spread by their weights.
struct Average {
  Eigen::VectorXd step;
  Eigen::MatrixXd covariance;
  double variance_horizontal = 0.0, variance_vertical = 0.0;
};

Average AverageOf(std::vector<Candidate> candidates) {
  double largest = candidates.front().log_weight;
  for (const auto& c : candidates) largest = std::max(largest, c.log_weight);
  const Eigen::Index size = candidates.front().step.size();
  Average average{Eigen::VectorXd::Zero(size), Eigen::MatrixXd::Zero(size, size)};
  double sum = 0.0;
  for (const auto& c : candidates) {
    const double weight = std::exp(c.log_weight - largest);
    sum += weight;
    average.step += weight * c.step;
    average.covariance += weight * (c.covariance + c.step * c.step.transpose());
    average.variance_horizontal += weight * c.variance;
    average.variance_vertical += weight * c.variance * c.ratio * c.ratio;
  }
  average.step /= sum;
  average.covariance = average.covariance / sum - average.step * average.step.transpose();
  average.variance_horizontal /= sum;
  average.variance_vertical /= sum;
  return average;
}

Average Solve(const LinearSystem& system, const CorrelationOptions& options,
              double least_variance) {
  std::vector<Candidate> candidates;
  for (const Correlation& correlation : CorrelationGrid(options)) {
    const WhitenedSystem whitened = Whiten(system, correlation);
    for (const Ratio& ratio : RatioGrid(options.prior)) {
      candidates.push_back(Evaluate(system, whitened, ratio, least_variance));
      candidates.back().log_weight += std::log(correlation.prior);
    }
  }
  return AverageOf(std::move(candidates));
}

// The variance of log(scale) that white noise of the same size would give.
double WhiteScaleVariance(const LinearSystem& system, const Average& average) {
  const WhitenedSystem white = Whiten(system, {0.0, 1.0, 1.0});
  Matrix7d normal =
      (white.horizontal / average.variance_horizontal + white.vertical / average.variance_vertical)
          .topLeftCorner<7, 7>();
  Damp(&normal);
  return normal.llt().solve(Matrix7d::Identity())(6, 6);
}

}  // namespace

CorrelatedFit FitCorrelated(const std::vector<PositionPair>& pairs, const Sim3& start,
                            const CorrelationOptions& options) {
  constexpr int kRounds = 5;
  const double least_variance = std::pow(NoiseFloor(pairs, start), 2);
  CorrelatedFit fit;
  fit.world_from_map = start;
  for (int round = 0; round < kRounds; ++round) {
    const SimilarityRows rows(pairs, fit.world_from_map);
    const LinearSystem system = Linearize(pairs, rows, options.with_time);
    const Average average = Solve(system, options, least_variance);
    fit.world_from_map = rows.Moved(average.step.head<7>());
    fit.sigma_horizontal = std::sqrt(average.variance_horizontal);
    fit.sigma_vertical = std::sqrt(average.variance_vertical);
    if (options.with_time) {
      fit.time_correction = average.step[kTime];
      fit.sigma_time = std::sqrt(average.covariance(kTime, kTime));
    }
    const double ratio = average.covariance(6, 6) / WhiteScaleVariance(system, average);
    fit.inflation = std::max(ratio, 1.0);
    fit.covariance =
        rows.AtMapOrigin(average.covariance.topLeftCorner<7, 7>()) * (fit.inflation / ratio);
  }
  return fit;
}

}  // namespace planegraph
