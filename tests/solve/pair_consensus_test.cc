#include "solve/pair_consensus.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

constexpr double kTilt = 0.02, kOffset = 0.005;

// A yard as two scans see it: patches of the ground by the hundred and a few of walls, each seen
// elsewhere by the second scan; three in five of them are taken for each other.
class Yard {
 public:
  Yard(int ground, int walls, std::uint64_t seed) : rng_(seed) {
    const Vector3d axis = Vector3d(Normal(), Normal(), Normal()).normalized();
    truth_ = {ExpSO3(2.0 * axis), {3.0 * Normal(), 3.0 * Normal(), Normal()}};
    for (int k = 0; k < ground; ++k) Add(Vector3d::UnitZ());
    for (int k = 0; k < walls; ++k) {
      const double azimuth = 0.3 + 0.5 * M_PI * (k % 4);
      Add({std::cos(azimuth), std::sin(azimuth), 0.0});
    }
    Mismatch(0.6);
  }

  const Rigid3& truth() const { return truth_; }
  const std::vector<SharedLandmark>& shared() const { return shared_; }

 private:
  double Normal() { return normal_(rng_); }

  Vector3d Tilted(const Vector3d& normal) {
    const Vector3d turn(Normal(), Normal(), Normal());
    return ExpSO3(kTilt / std::sqrt(2.0) * turn) * normal;
  }

  void Add(const Vector3d& normal) {
    const Vector3d height = 5.0 * Normal() * normal;
    const auto place = [&] {
      const Vector3d anywhere = 15.0 * Vector3d(Normal(), Normal(), Normal());
      return Vector3d(height + anywhere - normal.dot(anywhere) * normal +
                      kOffset / std::sqrt(2.0) * Normal() * normal);
    };
    const Rigid3 source_from_target = truth_.Inverse();
    shared_.push_back({Tilted(normal), place(), source_from_target.rotation * Tilted(normal),
                       source_from_target * place(), kTilt, kOffset});
  }

  void Mismatch(double share) {
    std::vector<SharedLandmark*> wrong;
    std::uniform_real_distribution<double> uniform;
    for (SharedLandmark& s : shared_) {
      if (uniform(rng_) < share) wrong.push_back(&s);
    }
    for (std::size_t i = wrong.size(); i > 1; --i) {
      SharedLandmark &a = *wrong[i - 1], &b = *wrong[rng_() % i];
      std::swap(a.source_normal, b.source_normal);
      std::swap(a.source_centroid, b.source_centroid);
    }
  }

  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
  Rigid3 truth_;
  std::vector<SharedLandmark> shared_;
};

// Normals alone tell the rotation, and at 30 m what is left of its error, and of the walls' tilts,
// makes half a metre; walls stand 5 m from each other.
bool IsRight(const PairConsensus& found, const Rigid3& truth) {
  return AngleBetween(found.target_from_source.rotation, truth.rotation) < 0.02 &&
         (found.target_from_source.translation - truth.translation).norm() < 1.5;
}

TEST(PairConsensus, FewWallsTellThePoseThatTheGroundLeavesOpen) {
  int sure = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Yard yard(220, 28, seed);
    const auto found = FindPairConsensus(yard.shared(), {});
    if (!found || found->log10_chance > -2.0) continue;
    EXPECT_TRUE(IsRight(*found, yard.truth())) << "sure, but wrong: seed " << seed;
    ++sure;
  }
  EXPECT_GE(sure, 50);
}

// Then nothing but the height and two angles are known.
TEST(PairConsensus, TheGroundAloneIsNotSure) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto found = FindPairConsensus(Yard(220, 0, seed).shared(), {});
    EXPECT_TRUE(!found || found->log10_chance > -2.0) << seed;
  }
}

}  // namespace
}  // namespace planegraph
