#include "planegraph/correspondence/surface_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "planegraph/geometry/cube_side.h"

namespace planegraph {
namespace {

class SurfaceFilterTest : public testing::Test {
 protected:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Eigen::Vector3d Direction() {
    std::normal_distribution<double> normal;
    return Eigen::Vector3d(normal(engine_), normal(engine_), normal(engine_)).normalized();
  }
  Eigen::Vector3d Place() { return {Uniform(-20, 20), Uniform(-20, 20), Uniform(-3, 6)}; }
  // A direction off another by at most the angle of kCosine.
  Eigen::Vector3d Near(const Eigen::Vector3d& direction) {
    const double angle = Uniform(0.0, std::acos(SurfaceFilter::kCosine) - 1e-6);
    return Eigen::AngleAxisd(angle, direction.unitOrthogonal()) * direction;
  }
  std::vector<SurfaceFace> Faces(int count) {
    std::vector<SurfaceFace> faces;
    faces.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) faces.push_back({Direction(), Place(), Uniform(0.1, 1.3)});
    return faces;
  }

  std::mt19937_64 engine_{5};
};

TEST_F(SurfaceFilterTest, SidesNearHoldsEveryDirectionNearBy) {
  for (int run = 0; run < 20000; ++run) {
    const Eigen::Vector3d d = Direction();
    EXPECT_NE(SurfaceFilter::SidesNear(d) >> CubeSide(Near(d)) & 1, 0u);
  }
  EXPECT_EQ(SurfaceFilter::SidesNear(Eigen::Vector3d::UnitX()), 1u);
  EXPECT_EQ(SurfaceFilter::SidesNear(-Eigen::Vector3d::UnitZ()), 32u);
}

TEST_F(SurfaceFilterTest, NeverDeniesAFace) {
  const auto faces = Faces(500);
  const SurfaceFilter filter(faces);
  for (int run = 0; run < 50000; ++run) {
    const SurfaceFace& face = faces[run % faces.size()];
    const Eigen::Vector3d along =
        Eigen::AngleAxisd(Uniform(0, 7), face.normal) * face.normal.unitOrthogonal();
    const Eigen::Vector3d point = face.mean + Uniform(0, 1) * face.reach * along +
                                  Uniform(-1, 1) * SurfaceFilter::kGate * face.normal;
    ASSERT_TRUE(filter.MayLie(point, CubeSide(Near(face.normal)))) << run;
  }
}

TEST_F(SurfaceFilterTest, MostlyDeniesPlacesFarFromAllFaces) {
  const auto faces = Faces(200);
  const SurfaceFilter filter(faces);
  int asked = 0, yes = 0;
  for (int run = 0; run < 20000; ++run) {
    const Eigen::Vector3d point = Place();
    const bool far = std::all_of(faces.begin(), faces.end(), [&](const SurfaceFace& face) {
      return (face.mean - point).norm() > face.reach + SurfaceFilter::kGate + 1.4;
    });
    if (!far) continue;
    ++asked, yes += filter.MayLie(point, run % 6);
  }
  ASSERT_GT(asked, 5000);
  EXPECT_LT(yes, asked / 5);  // hashes that are taken
}

TEST_F(SurfaceFilterTest, WithoutFacesEverythingIsDenied) {
  const SurfaceFilter none, empty(std::vector<SurfaceFace>{});
  EXPECT_FALSE(none.MayLie(Place(), 3));
  EXPECT_FALSE(empty.MayLie(Place(), 3));
}

}  // namespace
}  // namespace planegraph
