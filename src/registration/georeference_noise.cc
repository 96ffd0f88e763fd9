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

// Products of the system's columns, summed over the horizontal axes and over the vertical one.
struct Products {
  Gram horizontal = Gram::Zero(), vertical = Gram::Zero();
  // Weighted as if the vertical axis had `ratio` times the horizontal noise.
  Gram Weighted(double ratio) const { return horizontal + vertical / (ratio * ratio); }
};

// The products of the whitened system, and the determinant of one axis's correlation matrix.
struct WhitenedSystem {
  Products products;
  double log_determinant = 0.0;
};

struct Ratio {
  double value = 1.0, log_prior = 0.0;
};

// One set of noise parameters with its posterior weight.
struct CorrelationCandidate {
  Correlation correlation;
  double ratio = 1.0;     // of the vertical to the horizontal standard deviation
  double variance = 0.0;  // of a horizontal axis
  double log_weight = 0.0, weight = 0.0;
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

void AddProducts(const AxisRows& left, const AxisRows& right, double factor, Products* products) {
  products->horizontal += factor * left.topRows<2>().transpose() * right.topRows<2>();
  products->vertical += factor * left.row(2).transpose() * right.row(2);
}

double Decay(const LinearSystem& system, std::size_t k, const Correlation& correlation) {
  return k > 0 ? std::exp((system.times[k - 1] - system.times[k]) / correlation.time) : 0.0;
}

// A Kalman filter for the correlated part, run over all columns at once: its innovations are the
// rows whitened by the inverse Cholesky factor of the correlation matrix, in linear time.
WhitenedSystem Whiten(const LinearSystem& system, const Correlation& correlation) {
  WhitenedSystem whitened;
  AxisRows predicted = AxisRows::Zero();
  double variance = correlation.share;
  for (std::size_t k = 0; k < system.rows.size(); ++k) {
    const double decay = Decay(system, k, correlation);
    predicted *= decay;
    variance = decay * decay * variance + correlation.share * (1.0 - decay * decay);
    const double total = variance + (1.0 - correlation.share);
    const AxisRows innovation = system.rows[k] - predicted;
    predicted += variance / total * innovation;
    variance *= 1.0 - variance / total;
    AddProducts(innovation, innovation, 1.0 / total, &whitened.products);
    whitened.log_determinant += std::log(total);
  }
  return whitened;
}

// The sum over all i, j of row i times row j times their correlation, in linear time.
Products CorrelatedProducts(const LinearSystem& system, const Correlation& correlation) {
  Products products;
  AxisRows earlier = AxisRows::Zero();  // rows before, each with its correlation to this one
  for (std::size_t k = 0; k < system.rows.size(); ++k) {
    const AxisRows& row = system.rows[k];
    earlier *= Decay(system, k, correlation);
    AddProducts(row, row, 1.0, &products);
    AddProducts(row, earlier, correlation.share, &products);
    AddProducts(earlier, row, correlation.share, &products);
    earlier += row;
  }
  return products;
}

// The normal matrix of the parameters, damped where they are open.
Eigen::MatrixXd NormalMatrix(const Gram& gram, int parameters) {
  Eigen::MatrixXd normal = gram.topLeftCorner(parameters, parameters);
  Matrix7d similarity = normal.topLeftCorner<7, 7>();
  Damp(&similarity);
  normal.topLeftCorner<7, 7>() = similarity;
  if (parameters > kTime) normal(kTime, kTime) += 1e-12;  // at rest nothing tells the time
  return normal;
}

double Freedom(const LinearSystem& system) {
  return std::max(3.0 * static_cast<double>(system.rows.size()) - system.parameters, 1.0);
}

// The variance and the restricted likelihood of one set of noise parameters.
CorrelationCandidate Evaluate(const LinearSystem& system, const WhitenedSystem& whitened,
                              const Correlation& correlation, const Ratio& ratio,
                              double least_variance) {
  const Gram gram = whitened.products.Weighted(ratio.value);
  const int p = system.parameters;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(NormalMatrix(gram, p));
  const Eigen::VectorXd right = gram.col(kResidual).head(p);
  const double squares = gram(kResidual, kResidual) - right.dot(cholesky.solve(right));
  const double log_normal = 2.0 * cholesky.matrixLLT().diagonal().array().log().sum();
  const double count = static_cast<double>(system.rows.size()), freedom = Freedom(system);
  CorrelationCandidate result{correlation, ratio.value};
  result.variance = std::max(squares / freedom, least_variance);
  result.log_weight = ratio.log_prior + std::log(correlation.prior) -
                      0.5 * (freedom * std::log(result.variance) + 3.0 * whitened.log_determinant +
                             2.0 * count * std::log(ratio.value) + log_normal);
  return result;
}

// All sets of noise parameters, their weights summing to one.
std::vector<CorrelationCandidate> Candidates(const LinearSystem& system,
                                             const CorrelationOptions& options,
                                             double least_variance) {
  std::vector<CorrelationCandidate> candidates;
  for (const Correlation& correlation : CorrelationGrid(options)) {
    const WhitenedSystem whitened = Whiten(system, correlation);
    for (const Ratio& ratio : RatioGrid(options.prior)) {
      candidates.push_back(Evaluate(system, whitened, correlation, ratio, least_variance));
    }
  }
  double largest = candidates.front().log_weight, sum = 0.0;
  for (const auto& c : candidates) largest = std::max(largest, c.log_weight);
  for (auto& c : candidates) sum += c.weight = std::exp(c.log_weight - largest);
  for (auto& c : candidates) c.weight /= sum;
  return candidates;
}

// What the candidates say on average.
struct Noise {
  double variance_horizontal = 0.0, variance_vertical = 0.0, ratio = 1.0;
};

Noise AverageNoise(const std::vector<CorrelationCandidate>& candidates) {
  Noise noise;
  double log_ratio = 0.0;
  for (const auto& c : candidates) {
    noise.variance_horizontal += c.weight * c.variance;
    noise.variance_vertical += c.weight * c.variance * c.ratio * c.ratio;
    log_ratio += c.weight * std::log(c.ratio);
  }
  noise.ratio = std::exp(log_ratio);
  return noise;
}

// Student's distribution has a larger variance than the normal one of the same scale.
double StudentFactor(double freedom) {
  constexpr double kLargest = 10.0;
  return freedom > 2.0 ? std::min(freedom / (freedom - 2.0), kLargest) : kLargest;
}

// The sum of J^T W C W J over the axes, C the covariance of the positions' noise and W the weights
// of the fit; averaged over the candidates.
Gram AverageScore(const LinearSystem& system, const std::vector<CorrelationCandidate>& candidates,
                  double ratio) {
  constexpr double kNegligible = 1e-6;
  const double vertical_weight = std::pow(ratio, -4);
  Gram score = Gram::Zero();
  for (const auto& c : candidates) {
    if (c.weight < kNegligible) continue;
    const Products products = CorrelatedProducts(system, c.correlation);
    score += c.weight * c.variance *
             (products.horizontal + c.ratio * c.ratio * vertical_weight * products.vertical);
  }
  return score;
}

// One Gauss-Newton step with the covariance at its start.
class Solution {
 public:
  Solution(const LinearSystem& system, const CorrelationOptions& options, double least_variance)
      : system_(system),
        candidates_(Candidates(system, options, least_variance)),
        noise_(AverageNoise(candidates_)),
        white_(CorrelatedProducts(system, {})),
        gram_(white_.Weighted(noise_.ratio)),
        cholesky_(NormalMatrix(gram_, system.parameters)) {}

  const Noise& noise() const { return noise_; }
  Eigen::VectorXd Step() const {
    return -cholesky_.solve(gram_.col(kResidual).head(system_.parameters));
  }
  Eigen::MatrixXd Covariance() const {
    return Sandwich(AverageScore(system_, candidates_, noise_.ratio));
  }
  // What white noise of the same size would give.
  Eigen::MatrixXd WhiteCovariance() const {
    const double vertical = noise_.variance_vertical * std::pow(noise_.ratio, -4);
    return Sandwich(noise_.variance_horizontal * white_.horizontal + vertical * white_.vertical);
  }

 private:
  Eigen::MatrixXd Sandwich(const Gram& score) const {
    const int p = system_.parameters;
    // The damping goes in as well: what is open keeps a large variance.
    const double variance = noise_.variance_horizontal;
    const Eigen::MatrixXd damping = variance * (NormalMatrix(gram_, p) - gram_.topLeftCorner(p, p));
    const Eigen::MatrixXd half = cholesky_.solve(score.topLeftCorner(p, p) + damping);
    return StudentFactor(Freedom(system_)) * cholesky_.solve(half.transpose());
  }

  const LinearSystem& system_;
  std::vector<CorrelationCandidate> candidates_;
  Noise noise_;
  Products white_;
  Gram gram_;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
};

}  // namespace

CorrelatedFit FitCorrelated(const std::vector<PositionPair>& pairs, const Sim3& start,
                            const CorrelationOptions& options) {
  constexpr int kRounds = 3;
  const double least_variance = std::pow(NoiseFloor(pairs, start), 2);
  CorrelatedFit fit;
  fit.world_from_map = start;
  for (int round = 0; round < kRounds; ++round) {
    const SimilarityRows rows(pairs, fit.world_from_map);
    const LinearSystem system = Linearize(pairs, rows, options.with_time);
    const Solution solution(system, options, least_variance);
    const Eigen::VectorXd step = solution.Step();
    fit.world_from_map = rows.Moved(step.head<7>());
    if (options.with_time) fit.time_correction = step[kTime];
    if (round + 1 < kRounds) continue;
    const Eigen::MatrixXd covariance = solution.Covariance();
    const double ratio = covariance(6, 6) / solution.WhiteCovariance()(6, 6);
    fit.inflation = std::max(ratio, 1.0);
    fit.covariance = rows.AtMapOrigin(covariance.topLeftCorner<7, 7>() * (fit.inflation / ratio));
    if (options.with_time) fit.sigma_time = std::sqrt(covariance(kTime, kTime));
    fit.sigma_horizontal = std::sqrt(solution.noise().variance_horizontal);
    fit.sigma_vertical = std::sqrt(solution.noise().variance_vertical);
  }
  return fit;
}

}  // namespace planegraph
