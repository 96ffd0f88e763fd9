#include "solve/pair_consensus.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <random>

#include "planegraph/geometry/rotation.h"
#include "planegraph/registration/closed_form.h"
#include "solve/shared_directions.h"

namespace planegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLeastSine = 0.25;        // between the normals of a sample
constexpr double kLeastSampleSine = 0.5;   // between the first two rows for a translation
constexpr double kLeastVolume = 0.25;      // of the three
constexpr int kMostDraws = 50;             // for a row that stands apart from those before
constexpr std::size_t kMostRotations = 5;  // that get a translation
constexpr int kRefinements = 3;
constexpr std::size_t kMostRivals = 500;  // of the best pose that its lead is judged by
constexpr double kWidenings[] = {1.0, 2.0, 4.0};
constexpr double kSure = -3.0;  // log10 of the chance: no wider gate is tried

struct RotationGuess {
  Matrix3d target_from_source;
  Matrix3d covariance = Matrix3d::Zero();  // of the left perturbation
  std::vector<int> agreeing;
  double weight = 0.0;  // of those that agree
};

struct TriedPose {
  Sim3 pose;
  const RotationGuess* guess;
  std::vector<int> agreeing;  // increasing
  double weight;              // of them
};

// Half of the tilt's variance to each of the two planes.
PlaneMatch MakeMatch(const SharedLandmark& s) {
  const double variance = 0.5 * s.tilt_sigma * s.tilt_sigma;
  const auto fitted = [&](const Vector3d& normal, const Vector3d& centroid) {
    const Matrix3d tangent = Matrix3d::Identity() - normal * normal.transpose();
    return FittedPlane{normal, centroid, variance * tangent, 0.5 * s.offset_sigma * s.offset_sigma};
  };
  return {fitted(s.target_normal, s.target_centroid), fitted(s.source_normal, s.source_centroid)};
}

class ConsensusSearch {
 public:
  ConsensusSearch(const std::vector<SharedLandmark>& shared, const PairConsensusOptions& options)
      : shared_(shared),
        options_(options),
        direction_of_(DirectionsOf(shared)),
        weights_(WeightsOf(direction_of_)),
        rng_(options.seed) {
    for (const SharedLandmark& s : shared) matches_.push_back(MakeMatch(s));
  }

  std::optional<PairConsensus> Run() {
    const std::vector<RotationGuess> guesses = BestRotations();
    std::vector<TriedPose> tried;
    for (const RotationGuess& guess : guesses) TryTranslations(guess, &tried);
    std::stable_sort(tried.begin(), tried.end(),
                     [](const TriedPose& a, const TriedPose& b) { return a.weight > b.weight; });
    if (tried.empty() || static_cast<int>(tried[0].agreeing.size()) < SampleSize() + 2) return {};
    PairConsensus consensus;
    consensus.log10_chance = Log10Chance(tried);
    Refine(&tried[0]);
    consensus.target_from_source = tried[0].pose;
    consensus.agreeing.assign(shared_.size(), false);
    for (int k : tried[0].agreeing) consensus.agreeing[k] = true;
    consensus.agreeing_count = static_cast<int>(tried[0].agreeing.size());
    return consensus;
  }

 private:
  int SampleSize() const { return options_.scale_known ? 3 : 4; }
  double WeightOf(const std::vector<int>& agreeing) const {
    double sum = 0.0;
    for (int k : agreeing) sum += weights_[k];
    return sum;
  }
  int Draw(int count) { return static_cast<int>(rng_() % static_cast<std::uint64_t>(count)); }

  bool NormalsAgree(const Matrix3d& rotation, const Vector3d& target, const Vector3d& source,
                    double sigma) const {
    return (rotation * source - target).norm() <= options_.gate_sigmas * sigma;
  }

  std::vector<int> NormalsAgreeing(const Matrix3d& rotation, double widening) const {
    std::vector<int> agreeing;
    for (int k = 0; k < static_cast<int>(shared_.size()); ++k) {
      const SharedLandmark& s = shared_[k];
      if (NormalsAgree(rotation, s.target_normal, s.source_normal, widening * s.tilt_sigma)) {
        agreeing.push_back(k);
      }
    }
    return agreeing;
  }

  // The rotation that takes two normals to two others, the first and their plane exactly.
  static Matrix3d Triad(const Vector3d& a, const Vector3d& b) {
    Matrix3d axes;
    axes.col(0) = a;
    axes.col(1) = a.cross(b).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return axes;
  }

  std::optional<Matrix3d> RotationOfSample() {
    const SharedLandmark& a = shared_[Draw(static_cast<int>(shared_.size()))];
    const SharedLandmark& b = shared_[Draw(static_cast<int>(shared_.size()))];
    const double target_sine = a.target_normal.cross(b.target_normal).norm();
    const double source_sine = a.source_normal.cross(b.source_normal).norm();
    if (std::min(target_sine, source_sine) < kLeastSine) return {};
    const double difference = std::atan2(target_sine, a.target_normal.dot(b.target_normal)) -
                              std::atan2(source_sine, a.source_normal.dot(b.source_normal));
    const double sigma = std::hypot(a.tilt_sigma, b.tilt_sigma);
    if (std::abs(difference) > options_.gate_sigmas * sigma) return {};
    return Triad(a.target_normal, b.target_normal) *
           Triad(a.source_normal, b.source_normal).transpose();
  }

  // The closed form over the normals that agree, again as their set settles.
  void RefineRotation(RotationGuess* guess) const {
    for (int i = 0; i < kRefinements; ++i) {
      std::vector<PlaneMatch> matches;
      for (int k : guess->agreeing) matches.push_back(matches_[k]);
      const RotationSolution solution = SolveRotation(matches);
      guess->target_from_source = solution.target_from_source.toRotationMatrix();
      guess->covariance = solution.covariance;
      guess->agreeing = NormalsAgreeing(guess->target_from_source, 1.0);
    }
  }

  static double Angle(const Matrix3d& a, const Matrix3d& b) {
    return AngleBetween(Eigen::Quaterniond(a), Eigen::Quaterniond(b));
  }

  std::vector<RotationGuess> BestRotations() {
    std::vector<RotationGuess> guesses;
    for (int i = 0; i < options_.rotation_samples; ++i) {
      const auto rotation = RotationOfSample();
      // A sample's rotation has an error of its own beside that of the normals.
      if (!rotation) continue;
      std::vector<int> agreeing = NormalsAgreeing(*rotation, std::sqrt(2.0));
      const double weight = WeightOf(agreeing);
      guesses.push_back({*rotation, Matrix3d::Zero(), std::move(agreeing), weight});
    }
    std::stable_sort(guesses.begin(), guesses.end(),
                     [](const auto& a, const auto& b) { return a.weight > b.weight; });
    std::vector<RotationGuess> best;
    for (RotationGuess& guess : guesses) {
      if (best.size() == kMostRotations) break;
      RefineRotation(&guess);
      const bool is_new = std::all_of(best.begin(), best.end(), [&](const RotationGuess& other) {
        return Angle(guess.target_from_source, other.target_from_source) > 0.05;
      });
      if (is_new && static_cast<int>(guess.agreeing.size()) >= SampleSize()) best.push_back(guess);
    }
    return best;
  }

  // normal . (scale R c_source + t) = normal . c_target, as a row for (t, scale).
  struct Row {
    Eigen::Vector4d coefficients;
    double value;
  };

  static Row OffsetRow(const Matrix3d& rotation, const SharedLandmark& s) {
    const Vector3d normal = (s.target_normal + rotation * s.source_normal).normalized();
    Row row;
    row.coefficients << normal, normal.dot(rotation * s.source_centroid);
    row.value = normal.dot(s.target_centroid);
    return row;
  }

  // Rows whose normals stand well apart: most landmarks may lie on one floor, and samples at random
  // would seldom hold anything but it.
  bool DrawRows(const std::vector<Row>& rows, std::array<const Row*, 4>* drawn) {
    Matrix3d normals = Matrix3d::Zero();
    const int count = static_cast<int>(rows.size());
    for (int i = 0; i < SampleSize(); ++i) {
      bool found = false;
      for (int attempt = 0; attempt < kMostDraws && !found; ++attempt) {
        (*drawn)[i] = &rows[Draw(count)];
        if (i < 3) normals.row(i) = (*drawn)[i]->coefficients.head<3>();
        found = i == 0 || i == 3 ||
                (i == 1 && normals.row(0).cross(normals.row(1)).norm() > kLeastSampleSine) ||
                (i == 2 && std::abs(normals.determinant()) > kLeastVolume);
      }
      if (!found) return false;
    }
    return true;
  }

  std::optional<Eigen::Vector4d> SolveSample(const std::vector<Row>& rows) {
    std::array<const Row*, 4> drawn{};
    if (!DrawRows(rows, &drawn)) return {};
    Eigen::Matrix4d a = Eigen::Matrix4d::Identity();
    Eigen::Vector4d b = Eigen::Vector4d::Ones();  // where the scale is known it is 1
    for (int i = 0; i < SampleSize(); ++i) {
      a.row(i) = drawn[i]->coefficients;
      b[i] = drawn[i]->value;
    }
    const Eigen::FullPivLU<Eigen::Matrix4d> lu(a);
    if (!lu.isInvertible()) return {};
    const Eigen::Vector4d solution = lu.solve(b);
    if (!(solution[3] > 0.0) || !solution.allFinite()) return {};
    return solution;
  }

  // Of a landmark's height over its counterpart: by its own offset, its tilt, and the rotation.
  double HeightVariance(const Sim3& pose, const Matrix3d& rotation_covariance,
                        const SharedLandmark& s) const {
    const Vector3d turned = pose.scale * (pose.rotation * s.source_centroid);
    const Vector3d apart = turned + pose.translation - s.target_centroid;
    const Vector3d normal = (s.target_normal + pose.rotation * s.source_normal).normalized();
    const double lever = (apart - normal.dot(apart) * normal).norm();
    const Vector3d by_rotation = turned.cross(normal);
    return s.offset_sigma * s.offset_sigma + std::pow(0.5 * s.tilt_sigma * lever, 2) +
           by_rotation.dot(rotation_covariance * by_rotation);
  }

  bool OffsetAgrees(const Sim3& pose, const Matrix3d& rotation_covariance,
                    const SharedLandmark& s) const {
    const Vector3d apart = pose * s.source_centroid - s.target_centroid;
    const Vector3d normal = (s.target_normal + pose.rotation * s.source_normal).normalized();
    return std::abs(normal.dot(apart)) <=
           options_.gate_sigmas * std::sqrt(HeightVariance(pose, rotation_covariance, s));
  }

  static Sim3 PoseOf(const RotationGuess& guess, const Eigen::Vector4d& solution) {
    return {solution[3], Eigen::Quaterniond(guess.target_from_source), solution.head<3>()};
  }

  std::vector<int> OffsetsAgreeing(const Sim3& pose, const RotationGuess& guess) const {
    std::vector<int> agreeing;
    for (int k : guess.agreeing) {
      if (OffsetAgrees(pose, guess.covariance, shared_[k])) agreeing.push_back(k);
    }
    return agreeing;
  }

  // Least squares for the translation (and scale) over those that agree.
  Eigen::Vector4d Refit(const RotationGuess& guess, const std::vector<int>& agreeing) const {
    const int size = SampleSize();
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (int k : agreeing) {
      Row row = OffsetRow(guess.target_from_source, shared_[k]);
      if (options_.scale_known) row.value -= row.coefficients[3];
      if (options_.scale_known) row.coefficients[3] = 0.0;
      const double weight = 1.0 / (shared_[k].offset_sigma * shared_[k].offset_sigma);
      information += weight * row.coefficients * row.coefficients.transpose();
      right += weight * row.value * row.coefficients;
    }
    Eigen::Vector4d solution = Eigen::Vector4d::Ones();
    solution.head(size) = information.topLeftCorner(size, size).ldlt().solve(right.head(size));
    return solution;
  }

  void TryTranslations(const RotationGuess& guess, std::vector<TriedPose>* tried) {
    std::vector<Row> rows;
    for (int k : guess.agreeing) rows.push_back(OffsetRow(guess.target_from_source, shared_[k]));
    for (int i = 0; i < options_.translation_samples; ++i) {
      const auto solution = SolveSample(rows);
      if (!solution) continue;
      const Sim3 pose = PoseOf(guess, *solution);
      std::vector<int> agreeing = OffsetsAgreeing(pose, guess);
      const double weight = WeightOf(agreeing);
      tried->push_back({pose, &guess, std::move(agreeing), weight});
    }
  }

  void Refine(TriedPose* best) const {
    for (int i = 0; i < kRefinements; ++i) {
      const Eigen::Vector4d solution = Refit(*best->guess, best->agreeing);
      if (!solution.allFinite() || !(solution[3] > 0.0)) return;
      const Sim3 pose = PoseOf(*best->guess, solution);
      std::vector<int> agreeing = OffsetsAgreeing(pose, *best->guess);
      if (agreeing.size() < best->agreeing.size()) return;
      best->agreeing = std::move(agreeing);
      best->pose = pose;
    }
  }

  // Whether most of what agrees with `best` and faces some way would not agree with `other`. The
  // ways are judged each by itself: a ground has no say on where a wall stands.
  bool AreDistinct(const TriedPose& best, const TriedPose& other) const {
    if (best.guess != other.guess) return true;
    Eigen::Vector4d shift;
    shift << other.pose.translation - best.pose.translation, other.pose.scale - best.pose.scale;
    const double gate = 2.0 * options_.gate_sigmas;
    std::vector<double> beyond(shared_.size(), 0.0);  // by direction: chi2 above the gate's
    for (int k : best.agreeing) {
      const Row row = OffsetRow(best.guess->target_from_source, shared_[k]);
      beyond[direction_of_[k]] +=
          std::pow(row.coefficients.dot(shift), 2) /
              HeightVariance(best.pose, best.guess->covariance, shared_[k]) -
          gate * gate;
    }
    return std::any_of(beyond.begin(), beyond.end(), [](double sum) { return sum > 0.0; });
  }

  // Hoeffding's bound for `wins` or more heads of wins + losses throws.
  static double Log10Heads(double wins, double losses) {
    if (wins <= losses) return 0.0;
    const double n = wins + losses, share = wins / n;
    const double lost = losses > 0.0 ? (1.0 - share) * std::log(2.0 * (1.0 - share)) : 0.0;
    return -n * (share * std::log(2.0 * share) + lost) / std::log(10.0);
  }

  // Against the distinct pose that comes nearest; `tried` has the best pose first. What agrees with
  // both (a floor, say) does not count.
  double Log10Chance(const std::vector<TriedPose>& tried) const {
    double chance = Log10Heads(static_cast<double>(tried[0].agreeing.size()), 0.0);
    for (std::size_t i = 1; i < std::min(tried.size(), kMostRivals); ++i) {
      if (!AreDistinct(tried[0], tried[i])) continue;
      std::vector<int> both;
      std::set_intersection(tried[0].agreeing.begin(), tried[0].agreeing.end(),
                            tried[i].agreeing.begin(), tried[i].agreeing.end(),
                            std::back_inserter(both));
      chance =
          std::max(chance, Log10Heads(static_cast<double>(tried[0].agreeing.size() - both.size()),
                                      static_cast<double>(tried[i].agreeing.size() - both.size())));
    }
    return chance;
  }

  const std::vector<SharedLandmark>& shared_;
  const PairConsensusOptions& options_;
  std::vector<PlaneMatch> matches_;        // the same landmarks, as the closed form takes them
  std::vector<std::size_t> direction_of_;  // of each landmark
  std::vector<double> weights_;
  std::mt19937_64 rng_;
};

}  // namespace

std::optional<PairConsensus> FindPairConsensus(const std::vector<SharedLandmark>& shared,
                                               const PairConsensusOptions& options) {
  std::optional<PairConsensus> surest;
  if (static_cast<int>(shared.size()) < (options.scale_known ? 5 : 6)) return surest;
  for (double widening : kWidenings) {
    PairConsensusOptions wider = options;
    wider.gate_sigmas *= widening;
    auto found = ConsensusSearch(shared, wider).Run();
    if (!found || (surest && found->log10_chance >= surest->log10_chance)) continue;
    surest = std::move(found);
    surest->widening = widening;
    if (surest->log10_chance <= kSure) break;
  }
  return surest;
}

}  // namespace planegraph
