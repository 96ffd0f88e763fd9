// The photogrammetric model of whole scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "planegraph/simulation/mesh_parts.h"
#include "planegraph/simulation/photogrammetry.h"
#include "planegraph/simulation/scene.h"
#include "simulation/in_world.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

TEST(PhotogrammetrySceneTest, NothingInsideAClosedHall) {
  MeshBuilder builder;
  builder.AddFace({{-60, -60, 0}, {60, -60, 0}, {60, 60, 0}, {-60, 60, 0}});
  Shell shell;
  shell.size = {14.0, 12.0};
  shell.height = 5.0;
  shell.gable = 2.0;
  AddShell(&builder, Rigid3(), shell);
  AddPitchedRoof(&builder, Rigid3(), shell, 0.5, 0.25);
  Random random(3);
  const Flight flight = PlanFlight({-10.0, -10.0}, {24.0, 22.0}, FlightOptions(), &random);
  const PhotogrammetryModel model =
      Reconstruct(RayCaster(builder.mesh()), flight, PhotogrammetryOptions().WithoutNoise(), 3, 2);
  ASSERT_GT(model.cloud.size(), 10000u);
  int walls = 0;
  for (std::size_t i = 0; i < model.cloud.size(); ++i) {
    const Vector3d p = InWorld(model, i);
    ASSERT_FALSE(p.x() > 0.01 && p.x() < 13.99 && p.y() > 0.01 && p.y() < 11.99 && p.z() < 5.0)
        << p.transpose();
    const double up = builder.mesh().planes[model.labels[i]].normal.z();
    ASSERT_GT(up, -0.5) << "the underside of the roof";
    walls += std::abs(up) < 0.1;
  }
  EXPECT_GT(walls, 500) << "but its walls are seen";
}

class YardModelTest : public testing::TestWithParam<int> {
 protected:
  PhotogrammetryModel Model(PhotogrammetryOptions options, int threads = 2) const {
    options.pixel_step = 20;
    return Reconstruct(caster_, flight_, options, GetParam(), threads);
  }
  Flight Fly() const {
    FlightOptions options;
    options.overlap_along = 0.7;
    Random random(GetParam());
    return PlanFlight(scene_.area_low, scene_.area_high, options, &random);
  }

  SceneKind kind_ = GetParam() % 2 == 0 ? SceneKind::kYard : SceneKind::kQuarter;
  Scene scene_ = BuildScene(kind_, GetParam(), 35.0);
  RayCaster caster_{scene_.mesh};
  Flight flight_ = Fly();
};

TEST_P(YardModelTest, WithoutNoiseTheCloudLiesOnTheMeshAndTwoCamerasSeeIt) {
  const PhotogrammetryModel model = Model(PhotogrammetryOptions().WithoutNoise());
  ASSERT_GT(model.cloud.size(), 25000u);
  const auto sees = [&](std::size_t camera, const Vector3d& point) {
    const Rigid3& pose = flight_.world_from_camera[camera];
    if (!model.map_from_camera[camera]) return false;
    if (!flight_.camera.Project(pose.Inverse() * point)) return false;
    const double distance = (point - pose.translation).norm();
    const auto hit = caster_.Cast(pose.translation, (point - pose.translation) / distance, 100.0);
    return hit && std::abs(hit->distance - distance) < 0.02;
  };
  // Rounded to floats, a point on the rim of a leaf may slip out of sight.
  int checked = 0, hidden = 0;
  for (std::size_t i = 0; i < model.cloud.size(); i += 7) {
    const Vector3d p = InWorld(model, i);
    if (model.labels[i] != kNotPlanar) {
      ASSERT_NEAR(scene_.mesh.planes.at(model.labels[i]).SignedDistance(p), 0.0, 1e-3);
    }
    int seen = 0;
    for (std::size_t k = 0; k < flight_.times.size() && seen < 2; ++k) seen += sees(k, p);
    hidden += seen < 2 || !sees(model.views[i], p);
    ++checked;
  }
  EXPECT_LT(hidden, 0.002 * checked);
}

TEST_P(YardModelTest, WithNoiseMostPointsAreNearTheirPlanes) {
  PhotogrammetryOptions options;
  options.bowl = 0.0;
  const PhotogrammetryModel model = Model(options);
  std::vector<double> relative;
  std::size_t planar = 0;
  for (std::size_t i = 0; i < model.cloud.size(); ++i) {
    if (model.labels[i] == kNotPlanar) continue;
    ++planar;
    const Plane& plane = scene_.mesh.planes[model.labels[i]];
    const Vector3d p = InWorld(model, i);
    const Vector3d ray = p - flight_.world_from_camera[model.views[i]].translation;
    const double cosine = std::abs(ray.normalized().dot(plane.normal));
    relative.push_back(std::abs(plane.SignedDistance(p)) / (model.sigmas[i] * cosine));
  }
  EXPECT_GT(planar, 0.85 * static_cast<double>(model.cloud.size()));
  std::sort(relative.begin(), relative.end());
  // Quantiles of the absolute value of a standard normal variable.
  EXPECT_NEAR(relative[relative.size() / 2], 0.674, 0.05);
  EXPECT_NEAR(relative[relative.size() * 95 / 100], 1.96, 0.15);
}

TEST_P(YardModelTest, NormalsPointToTheCamerasAndHaveTheStatedErrors) {
  const PhotogrammetryModel model = Model(PhotogrammetryOptions());
  std::size_t away = 0, planar = 0;
  double square = 0.0;
  for (std::size_t i = 0; i < model.cloud.size(); ++i) {
    const Vector3d normal = model.world_from_map.rotation * model.cloud.normals[i].cast<double>();
    ASSERT_NEAR(normal.norm(), 1.0, 1e-5);
    const Vector3d to_camera =
        flight_.world_from_camera[model.views[i]].translation - InWorld(model, i);
    away += normal.dot(to_camera) < 0.0;
    if (model.labels[i] == kNotPlanar) continue;
    const double sine = normal.cross(scene_.mesh.planes[model.labels[i]].normal).norm();
    square += sine * sine;
    ++planar;
  }
  EXPECT_LT(away, 0.02 * static_cast<double>(model.cloud.size()));
  // Two of the three axes of the random turn move the normal, and so does the bowl a little.
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(planar)), 0.09 * std::sqrt(2.0), 0.003);
}

TEST_P(YardModelTest, EqualForAnyThreads) {
  const PhotogrammetryModel one = Model(PhotogrammetryOptions(), 1);
  const PhotogrammetryModel three = Model(PhotogrammetryOptions(), 3);
  EXPECT_TRUE(one.cloud.points == three.cloud.points);
  EXPECT_TRUE(one.cloud.normals == three.cloud.normals);
  EXPECT_TRUE(one.cloud.colors == three.cloud.colors);
  EXPECT_TRUE(one.sigmas == three.sigmas);
  EXPECT_TRUE(one.labels == three.labels);
}

INSTANTIATE_TEST_SUITE_P(Scenes, YardModelTest, testing::Range(0, 2));

}  // namespace
}  // namespace planegraph
