#include "planegraph/registration/closed_form.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Matches = std::vector<PlaneMatch>;

FittedPlane MakePlane(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                      double tilt_sigma = 1e-3, double offset_sigma = 0.01) {
  const Eigen::Vector3d n = normal.normalized();
  return {n, centroid, tilt_sigma * tilt_sigma * (Eigen::Matrix3d::Identity() - n * n.transpose()),
          offset_sigma * offset_sigma};
}

FittedPlane Moved(const Rigid3& to_from, const FittedPlane& plane) {
  const Eigen::Matrix3d r = to_from.rotation.toRotationMatrix();
  return {r * plane.normal, to_from * plane.centroid, r * plane.normal_covariance * r.transpose(),
          plane.offset_variance};
}

Rigid3 TruePose() {
  return {ExpSO3(Eigen::Vector3d(0.1, -0.2, 0.9)), Eigen::Vector3d(3.0, -1.5, 0.4)};
}

class RandomMotions {
 public:
  explicit RandomMotions(std::uint64_t seed) : rng_(seed) {}
  Eigen::Vector3d Vector(double size) {
    std::normal_distribution<double> normal(0.0, size);
    const double x = normal(rng_), y = normal(rng_), z = normal(rng_);
    return {x, y, z};
  }
  Rigid3 Pose() {
    const Eigen::Vector3d r = Vector(1.0), t = Vector(5.0);
    return {ExpSO3(r), t};
  }

 private:
  std::mt19937_64 rng_;
};

// Exact planes with these normals in the target, at random places; the source's centroids are other
// places of the same planes.
Matches ExactMatches(const std::vector<Eigen::Vector3d>& normals, const Rigid3& target_from_source,
                     double tilt_sigma = 1e-3) {
  RandomMotions random(7);
  Matches matches;
  for (const auto& normal : normals) {
    const FittedPlane target = MakePlane(normal, random.Vector(8.0), tilt_sigma);
    FittedPlane seen = target;
    seen.centroid += TangentBasis(target.normal) * random.Vector(2.0).head<2>();
    matches.push_back({target, Moved(target_from_source.Inverse(), seen)});
  }
  return matches;
}

Matches NoisyMatches(std::uint64_t seed, double tilt_sigma = 2e-3, double offset_sigma = 0.01) {
  RandomMotions random(seed);
  Matches matches;
  for (int k = 0; k < 9; ++k) {
    const FittedPlane t =
        MakePlane(random.Vector(1.0), random.Vector(8.0), tilt_sigma, offset_sigma);
    const Eigen::Vector3d tilt = t.normal.cross(random.Vector(tilt_sigma));
    FittedPlane s =
        MakePlane(ExpSO3(tilt) * t.normal, t.centroid + random.Vector(offset_sigma).x() * t.normal,
                  tilt_sigma, offset_sigma);
    s.centroid += TangentBasis(s.normal) * random.Vector(1.5).head<2>();
    matches.push_back({t, Moved(TruePose().Inverse(), s)});
  }
  return matches;
}

double Distance(const Rigid3& a, const Rigid3& b) {
  return (a.translation - b.translation).norm() + AngleBetween(a.rotation, b.rotation);
}

const Eigen::Vector3d kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

TEST(ClosedFormTest, ExactPlanesGiveTheExactPose) {
  const auto pose = SolveClosedForm(ExactMatches({kX, kY, kZ, -kX, kX + kY}, TruePose()));
  EXPECT_LT(Distance(pose.target_from_source, TruePose()), 1e-9);
  EXPECT_EQ(pose.rank, 3);
  EXPECT_TRUE(pose.unique_rotation);
  EXPECT_TRUE(pose.unobserved.empty());
}

TEST(ClosedFormTest, TwoDirectionsAreEnoughForTheRotation) {
  const auto rotation = SolveRotation(ExactMatches({kX, kZ}, TruePose()));
  EXPECT_TRUE(rotation.unique);
  EXPECT_LT(AngleBetween(rotation.target_from_source, TruePose().rotation), 1e-9);
  EXPECT_NEAR(rotation.target_from_source.toRotationMatrix().determinant(), 1.0, 1e-12);
}

TEST(ClosedFormTest, NoisyCoplanarNormalsNeverGiveAReflection) {
  RandomMotions random(3);
  for (int trial = 0; trial < 200; ++trial) {
    Matches matches = ExactMatches({kX, kY, kX + kY}, TruePose());
    for (auto& m : matches) m.source.normal = (m.source.normal + random.Vector(0.02)).normalized();
    const auto rotation = SolveRotation(matches);
    EXPECT_LT(AngleBetween(rotation.target_from_source, TruePose().rotation), 0.15);
  }
}

TEST(ClosedFormTest, ParallelNormalsLeaveTheRotationFreeUnlessThereIsAPrior) {
  const Matches matches = ExactMatches({kZ, kZ, kZ}, TruePose());
  EXPECT_FALSE(SolveRotation(matches).unique);
  const auto pose = SolveClosedForm(matches);
  const auto turn = std::find_if(pose.unobserved.begin(), pose.unobserved.end(), [](const auto& u) {
    return u.direction.template tail<3>().norm() > 0.5;
  });
  ASSERT_NE(turn, pose.unobserved.end());
  EXPECT_NEAR(std::abs(turn->direction[5]), 1.0, 1e-6);  // about the planes' normal
  EXPECT_TRUE(std::isnan(turn->sigma));
  const auto held = SolveRotation(matches, RotationPrior{TruePose().rotation, 0.02});
  EXPECT_TRUE(held.unique);
  EXPECT_LT(AngleBetween(held.target_from_source, TruePose().rotation), 1e-7);
  EXPECT_NEAR(std::sqrt(held.covariance(2, 2)), 0.02, 1e-6);
}

TEST(ClosedFormTest, OneNormalIsMappedByTheShortestRotation) {
  const Rigid3 tilt(ExpSO3(Eigen::Vector3d(0.3, 0.1, 0.0)), Eigen::Vector3d::Zero());
  const auto rotation = SolveRotation(ExactMatches({kZ}, tilt));
  EXPECT_LT(AngleBetween(rotation.target_from_source, tilt.rotation), 1e-6);
}

// The paper's equation (2) divides the projection of the estimate by sigma_1: a length in metres
// would shrink with the number of planes. Pinned here: rank 2, exact planes, known estimate.
TEST(ClosedFormTest, MissingDirectionIsTheEstimatesProjection) {
  const Matches matches = ExactMatches({kX, kY, -kX, kX, kY}, TruePose());
  PosePrior prior;
  prior.target_from_source = {TruePose().rotation,
                              TruePose().translation + Eigen::Vector3d(0.3, -0.2, 0.7)};
  prior.covariance = Matrix6d::Identity();
  ClosedFormOptions options;
  options.open = OpenDirections::kProjection;
  const auto pose = SolveClosedForm(matches, options, prior, "odometry");
  EXPECT_EQ(pose.rank, 2);
  const Eigen::Vector3d expected = TruePose().translation + Eigen::Vector3d(0, 0, 0.7);
  EXPECT_LT((pose.target_from_source.translation - expected).norm(), 1e-6);
  ASSERT_EQ(pose.unobserved.size(), 1u);
  EXPECT_NEAR(std::abs(pose.unobserved[0].direction[2]), 1.0, 1e-6);
  EXPECT_NEAR(pose.unobserved[0].sigma, 1.0, 1e-3);
  EXPECT_EQ(pose.unobserved[0].held_by, "odometry");
}

// Six walls facing x and one facing y: singular values in the ratio sqrt(6) to 1. With sigma_1 in
// all terms, as printed, 41 % of the y translation would come back.
TEST(ClosedFormTest, EveryDirectionHasItsOwnSingularValue) {
  Matches matches = ExactMatches({kX, kX, kX, kX, kX, kX, kY}, TruePose(), 1e-6);
  const RotationSolution rotation = SolveRotation(matches);
  const TranslationPrior prior{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()};
  ClosedFormOptions options;
  options.open = OpenDirections::kProjection;
  const auto solution = SolveTranslation(matches, rotation, options, prior);
  EXPECT_EQ(solution.rank, 2);
  EXPECT_NEAR(solution.singular_values[0] / solution.singular_values[1], std::sqrt(6.0), 1e-3);
  EXPECT_NEAR(solution.translation.x(), TruePose().translation.x(), 1e-6);
  EXPECT_NEAR(solution.translation.y(), TruePose().translation.y(), 1e-6);
  EXPECT_NEAR(solution.translation.z(), 0.0, 1e-6);
}

TEST(ClosedFormTest, SoftPriorHoldsWhatPlanesLeaveOpen) {
  const Matches matches = ExactMatches({kX, kY, -kX, kX, kY}, TruePose());
  PosePrior prior{TruePose(), Matrix6d::Identity() * 0.04};
  prior.target_from_source.translation += Eigen::Vector3d(0.1, 0.1, 0.1);
  const auto pose = SolveClosedForm(matches, {}, prior, "odometry");
  const Eigen::Vector3d error = pose.target_from_source.translation - TruePose().translation;
  EXPECT_NEAR(error.z(), 0.1, 1e-3);
  EXPECT_LT(error.head<2>().norm(), 2e-3);
  EXPECT_NEAR(std::sqrt(pose.covariance(2, 2)), 0.2, 2e-3);
  EXPECT_LT(std::sqrt(pose.covariance(0, 0)), 0.02);
}

TEST(ClosedFormTest, NoiseOfNormalsIsNoInformation) {
  // Forty walls whose normals scatter by two degrees about x, as their covariance says.
  RandomMotions random(5);
  std::vector<Eigen::Vector3d> normals;
  for (int k = 0; k < 40; ++k) normals.push_back(kX + random.Vector(0.035));
  const Matches matches = ExactMatches(normals, TruePose(), 0.035);
  ClosedFormOptions options;
  options.most_sigma = 10.0;
  const RotationSolution known{TruePose().rotation, 1e-10 * Eigen::Matrix3d::Identity(),
                               1e10 * Eigen::Matrix3d::Identity(), 1.0, true};
  EXPECT_EQ(SolveTranslation(matches, known, options).rank, 1);
  options.spurious_factor = 0.0;
  EXPECT_EQ(SolveTranslation(matches, known, options).rank, 3);
}

TEST(ClosedFormTest, NoPlanesLeaveThePrior) {
  const PosePrior prior{TruePose(), Matrix6d::Identity() * 0.01};
  const auto pose = SolveClosedForm({}, {}, prior);
  EXPECT_LT(Distance(pose.target_from_source, TruePose()), 1e-9);
  EXPECT_EQ(pose.unobserved.size(), 6u);
  EXPECT_NEAR(pose.covariance(0, 0), 0.01, 1e-6);
}

TEST(ClosedFormProperty, MovingTheFramesMovesThePose) {
  const Matches matches = NoisyMatches(1);
  const Rigid3 pose = SolveClosedForm(matches).target_from_source;
  RandomMotions random(9);
  for (int trial = 0; trial < 20; ++trial) {
    const Rigid3 a = random.Pose(), b = random.Pose();
    Matches moved;
    for (const auto& m : matches) moved.push_back({Moved(a, m.target), Moved(b, m.source)});
    EXPECT_LT(Distance(SolveClosedForm(moved).target_from_source, a * pose * b.Inverse()), 1e-9);
  }
}

TEST(ClosedFormProperty, SwappingTheCloudsInvertsThePose) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Matches matches = NoisyMatches(seed);
    Matches swapped;
    for (const auto& m : matches) swapped.push_back({m.source, m.target});
    EXPECT_LT(Distance(SolveClosedForm(swapped).target_from_source.Inverse(),
                       SolveClosedForm(matches).target_from_source),
              1e-9);
  }
}

TEST(ClosedFormProperty, OrderOfThePlanesDoesNotMatter) {
  Matches matches = NoisyMatches(2);
  const ClosedFormPose pose = SolveClosedForm(matches);
  std::reverse(matches.begin(), matches.end());
  std::swap(matches[1], matches[4]);
  const ClosedFormPose other = SolveClosedForm(matches);
  EXPECT_LT(Distance(pose.target_from_source, other.target_from_source), 1e-12);
  EXPECT_TRUE(pose.covariance.isApprox(other.covariance, 1e-9));
}

TEST(ClosedFormProperty, ScaleOfTheCovariancesScalesTheResultsAlone) {
  Matches matches = NoisyMatches(2);
  const ClosedFormPose pose = SolveClosedForm(matches);
  for (auto& m : matches) {
    for (FittedPlane* plane : {&m.target, &m.source}) {
      plane->normal_covariance *= 4.0;
      plane->offset_variance *= 4.0;
    }
  }
  const ClosedFormPose other = SolveClosedForm(matches);
  EXPECT_LT(Distance(pose.target_from_source, other.target_from_source), 1e-12);
  EXPECT_TRUE((4.0 * pose.covariance).isApprox(other.covariance, 1e-9));
}

TEST(ClosedFormProperty, CovarianceIsHonest) {
  // Mean normalized squared error of a six-vector is six; 400 trials leave +-0.35 at two sigma.
  double sum = 0.0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    // Both planes of a pair carry the stated noise; NoisyMatches disturbs one of the two.
    Matches matches = NoisyMatches(100 + trial);
    for (auto& m : matches) {
      m.target.normal_covariance *= 0.5, m.target.offset_variance *= 0.5;
      m.source.normal_covariance *= 0.5, m.source.offset_variance *= 0.5;
    }
    const ClosedFormPose pose = SolveClosedForm(matches);
    Eigen::Matrix<double, 6, 1> error;
    error << pose.target_from_source.translation - TruePose().translation,
        LogSO3(pose.target_from_source.rotation * TruePose().rotation.conjugate());
    sum += error.dot(pose.covariance.inverse() * error);
  }
  EXPECT_NEAR(sum / kTrials, 6.0, 0.9);
}

}  // namespace
}  // namespace planegraph
