#include "planegraph/simulation/photogrammetry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/simulation/mesh_parts.h"
#include "simulation/in_world.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

// Looks straight down, with north upwards in the image.
Rigid3 Down(const Vector3d& position) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(3.141592653589793, Vector3d::UnitX())), position};
}

// Level ground at z = 0 and `count` cameras in a row, 20 m above it and 5 m apart.
struct Meadow {
  explicit Meadow(int count) {
    builder.AddFace({{-60, -60, 0}, {60, -60, 0}, {60, 60, 0}, {-60, 60, 0}});
    for (int k = 0; k < count; ++k) {
      flight.world_from_camera.push_back(Down({5.0 * k, 0.0, 20.0}));
      flight.times.push_back(k);
    }
  }
  PhotogrammetryModel Model(const PhotogrammetryOptions& options, std::uint64_t seed = 1) const {
    return Reconstruct(RayCaster(builder.mesh()), flight, options, seed, 2);
  }

  MeshBuilder builder;
  Flight flight;
};

// Nothing but errors of depths, everywhere, with all cameras placed.
PhotogrammetryOptions DepthErrorsAlone() {
  PhotogrammetryOptions options = PhotogrammetryOptions().WithoutNoise();
  options.disparity_sigma = 0.5;
  options.hole_share = options.unregistered_share = options.poor_planes = 0.0;
  options.max_sigma = 10.0;
  return options;
}

// Errors of the meadow's depths in units of their standard deviation, with the places.
struct Residual {
  Vector3d place;
  double value;
  int view;
};
std::vector<Residual> Residuals(const Meadow& meadow, const PhotogrammetryModel& model) {
  std::vector<Residual> residuals;
  for (std::size_t i = 0; i < model.cloud.size(); ++i) {
    const Vector3d point = InWorld(model, i);
    const Vector3d& camera = meadow.flight.world_from_camera[model.views[i]].translation;
    const Vector3d ray = (point - camera).normalized();
    const Vector3d exact = camera + ray * (camera.z() / -ray.z());
    residuals.push_back({exact, (point - exact).dot(ray) / model.sigmas[i], model.views[i]});
  }
  return residuals;
}

// Mean product of the residuals of two views at places so far from each other, over some runs.
double Correlation(const std::vector<std::vector<Residual>>& runs, int view_a, int view_b,
                   double nearest, double farthest) {
  double sum = 0.0;
  int count = 0;
  for (const auto& residuals : runs) {
    for (const Residual& a : residuals) {
      if (a.view != view_a) continue;
      for (const Residual& b : residuals) {
        if (b.view != view_b || &a == &b) continue;
        const double square = (a.place - b.place).squaredNorm();
        if (square < nearest * nearest || square > farthest * farthest) continue;
        sum += a.value * b.value;
        ++count;
      }
    }
  }
  EXPECT_GT(count, 500);
  return sum / count;
}

TEST(DepthErrorTest, SigmaIsThatOfTheTextbook) {
  const Meadow meadow(2);
  const PhotogrammetryModel model = meadow.Model(DepthErrorsAlone());
  ASSERT_GT(model.cloud.size(), 500u);
  int below = 0;
  for (std::size_t i = 0; i < model.cloud.size(); ++i) {
    const Vector3d point = InWorld(model, i);
    const Vector3d& camera = meadow.flight.world_from_camera[model.views[i]].translation;
    if ((point - camera).head<2>().norm() > 0.7) continue;  // nearly straight down
    // Z^2 sigma / (f b) with 20 m, half a pixel, 460 pixels and 5 m.
    EXPECT_NEAR(model.sigmas[i], 400.0 * 0.5 / (460.0 * 5.0), 0.002);
    ++below;
  }
  EXPECT_GT(below, 5);
}

TEST(DepthErrorTest, ErrorsHaveTheStatedSpread) {
  double square = 0.0, sum = 0.0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Meadow meadow(3);
    for (const Residual& r : Residuals(meadow, meadow.Model(DepthErrorsAlone(), seed))) {
      square += r.value * r.value;
      sum += r.value;
      ++count;
    }
  }
  // Some 8 x 1500 independent patches of the correlation length.
  EXPECT_NEAR(sum / count, 0.0, 0.05);
  EXPECT_NEAR(square / count, 1.0, 0.06);
}

TEST(DepthErrorTest, NeighboursShareTheirErrorsAndImagesAPartOfThem) {
  PhotogrammetryOptions options = DepthErrorsAlone();
  options.pixel_step = 8;
  options.surface_share = 0.3;
  options.image_share = 0.5;
  options.correlation_length = 1.2;
  const Meadow meadow(2);
  std::vector<std::vector<Residual>> runs;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    runs.push_back(Residuals(meadow, meadow.Model(options, seed)));
  }
  EXPECT_NEAR(Correlation(runs, 0, 0, 0.0, 0.18), 0.8, 0.1) << "all but the white part";
  EXPECT_NEAR(Correlation(runs, 0, 1, 0.0, 0.18), 0.3, 0.1) << "the surface's part";
  EXPECT_NEAR(Correlation(runs, 0, 0, 3.6, 4.2), 0.0, 0.05) << "far apart";
  const double half = Correlation(runs, 0, 0, 0.8, 1.0);
  EXPECT_GT(half, 0.2);
  EXPECT_LT(half, 0.6);
}

TEST(PhotogrammetryTest, OneImageGivesNoDepth) {
  const PhotogrammetryModel model = Meadow(1).Model(DepthErrorsAlone());
  EXPECT_EQ(model.cloud.size(), 0u);
  EXPECT_EQ(model.map_from_camera.size(), 1u);
}

TEST(PhotogrammetryTest, NoFlightIsAnEmptyModel) {
  EXPECT_EQ(Meadow(0).Model(DepthErrorsAlone()).cloud.size(), 0u);
}

TEST(PhotogrammetryTest, OutliersAreFewAndFar) {
  PhotogrammetryOptions options = DepthErrorsAlone();
  options.disparity_sigma = 0.0;
  options.outlier_share = 0.05;
  options.outlier_sigma = 2.0;
  const Meadow meadow(4);
  const PhotogrammetryModel model = meadow.Model(options);
  int off = 0;
  double square = 0.0;
  for (std::size_t i = 0; i < model.cloud.size(); ++i) {
    const Vector3d point = InWorld(model, i);
    if (std::abs(point.z()) < 1e-3) continue;
    ++off;
    square += point.z() * point.z();
  }
  EXPECT_NEAR(off / static_cast<double>(model.cloud.size()), 0.05, 0.01);
  EXPECT_NEAR(std::sqrt(square / off), 2.0, 0.3);
}

TEST(PhotogrammetryTest, TheBowlIsAParaboloidOfTheStatedSize) {
  PhotogrammetryOptions options = DepthErrorsAlone();
  options.disparity_sigma = 0.0;
  options.bowl = 0.01;
  const Meadow meadow(9);  // 40 m long: half extent 20 m about x = 20
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const PhotogrammetryModel model = meadow.Model(options, seed);
    const auto height = [&](std::size_t i) { return InWorld(model, i).z(); };
    const auto square = [&](std::size_t i) {
      return (InWorld(model, i).head<2>() - Eigen::Vector2d(20.0, 0.0)).squaredNorm();
    };
    // z = curvature (r^2 - 20^2 / 2), from any point off the zero.
    std::size_t k = 0;
    while (square(k) < 300.0) ++k;
    const double curvature = height(k) / (square(k) - 200.0);
    const double rim = curvature * (400.0 - 0.0);  // against the middle
    EXPECT_GT(std::abs(rim), 0.5 * 0.01 * 20.0 - 1e-3);
    EXPECT_LT(std::abs(rim), 1.5 * 0.01 * 20.0 + 1e-3);
    for (std::size_t i = 0; i < model.cloud.size(); ++i) {
      ASSERT_NEAR(height(i), curvature * (square(i) - 200.0), 2e-3);
    }
    // The cameras are part of the model.
    const Vector3d first = model.world_from_map * model.map_from_camera[0]->translation;
    EXPECT_NEAR(first.z() - 20.0, curvature * 200.0, 1e-3);
  }
}

TEST(PhotogrammetryTest, CamerasHaveTheStatedErrors) {
  PhotogrammetryOptions options = DepthErrorsAlone();
  options.position_sigma = 0.02;
  options.rotation_sigma = 0.0005;
  options.pixel_step = 240;
  const Meadow meadow(300);
  const PhotogrammetryModel model = meadow.Model(options);
  double position = 0.0, rotation = 0.0;
  for (std::size_t k = 0; k < 300; ++k) {
    const Rigid3& truth = meadow.flight.world_from_camera[k];
    ASSERT_TRUE(model.map_from_camera[k].has_value());
    const Vector3d center = model.world_from_map * model.map_from_camera[k]->translation;
    const Eigen::Quaterniond turned =
        model.world_from_map.rotation * model.map_from_camera[k]->rotation;
    position += (center - truth.translation).squaredNorm() / 900.0;
    rotation += std::pow(AngleBetween(turned, truth.rotation), 2) / 900.0;
  }
  EXPECT_NEAR(std::sqrt(position), 0.02, 0.002);
  EXPECT_NEAR(std::sqrt(rotation), 0.0005, 0.00005);
}

TEST(PhotogrammetryTest, UnregisteredImagesGiveNoDepths) {
  PhotogrammetryOptions options = DepthErrorsAlone();
  options.unregistered_share = 0.5;
  const PhotogrammetryModel model = Meadow(12).Model(options);
  const auto missing = std::count_if(model.map_from_camera.begin(), model.map_from_camera.end(),
                                     [](const auto& pose) { return !pose.has_value(); });
  EXPECT_GT(missing, 0);
  EXPECT_LT(missing, 11);
  for (const int view : model.views) EXPECT_TRUE(model.map_from_camera[view].has_value());
}

TEST(PhotogrammetryTest, FramesDifferBySeedAndScalesLieInTheirRange) {
  const PhotogrammetryOptions options = DepthErrorsAlone();
  std::vector<Sim3> frames;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Sim3 frame = Meadow(1).Model(options, seed).world_from_map;
    EXPECT_GE(frame.scale, 6.0);
    EXPECT_LT(frame.scale, 11.0);
    for (const Sim3& other : frames) {
      EXPECT_GT(AngleBetween(frame.rotation, other.rotation), 0.01);
      EXPECT_NE(frame.scale, other.scale);
    }
    frames.push_back(frame);
  }
}

// The nearest pixel ring of a roof's edge shows both the roof and the ground below.
TEST(PhotogrammetryTest, SmoothingLeavesPlanesAsTheyAreAndBlursEdges) {
  Meadow meadow(4);
  AddBox(&meadow.builder, Rigid3(), {4.0, -3.0, 0.0}, {10.0, 3.0, 1.0});
  PhotogrammetryOptions options = DepthErrorsAlone();
  options.disparity_sigma = 0.0;
  options.smoothing = 0.7;
  const PhotogrammetryModel model = meadow.Model(options);
  int blurred = 0;
  for (std::size_t i = 0; i < model.cloud.size(); ++i) {
    const Vector3d p = InWorld(model, i);
    if (model.labels[i] == kNotPlanar) {
      ++blurred;
      EXPECT_GT(p.z(), -1e-3) << "a blend lies between the surfaces";
      EXPECT_LT(p.z(), 1.0 + 1e-3);
      continue;
    }
    EXPECT_NEAR(meadow.builder.mesh().planes[model.labels[i]].SignedDistance(p), 0.0, 0.021);
  }
  EXPECT_GT(blurred, 20);
  EXPECT_LT(blurred, 0.1 * static_cast<double>(model.cloud.size()));
}

TEST(PhotogrammetryTest, PoorTextureLeavesHoles) {
  Meadow meadow(4);
  AddBox(&meadow.builder, Rigid3(), {-2.0, 6.0, 0.0}, {14.0, 9.0, 4.0});
  PhotogrammetryOptions options = DepthErrorsAlone();
  const auto count_walls = [&](const PhotogrammetryModel& model) {
    return std::count_if(model.labels.begin(), model.labels.end(), [&](int label) {
      return std::abs(meadow.builder.mesh().planes[label].normal.z()) < 0.5;
    });
  };
  options.pixel_step = 8;
  const PhotogrammetryModel all = meadow.Model(options);
  options.poor_planes = 1.0;
  const PhotogrammetryModel poor = meadow.Model(options);
  ASSERT_GT(count_walls(all), 300);
  EXPECT_NEAR(count_walls(poor) / static_cast<double>(count_walls(all)), options.poor_kept, 0.08);
  options.hole_share = 0.3;
  const PhotogrammetryModel holes = meadow.Model(options);
  EXPECT_NEAR(holes.cloud.size() / static_cast<double>(poor.cloud.size()), 1.0 - 0.9 * 0.3, 0.12);
}

TEST(PhotogrammetryTest, RefusesOptionsWithoutSense) {
  const auto refused = [](const std::function<void(PhotogrammetryOptions*)>& change) {
    PhotogrammetryOptions options;
    change(&options);
    EXPECT_THROW(Meadow(2).Model(options), UsageError);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([](auto* o) { o->pixel_step = 0; });
  refused([](auto* o) { o->pixel_step = 481; });
  refused([](auto* o) { o->surface_share = 0.7; });
  refused([&](auto* o) { o->image_share = nan; });
  refused([](auto* o) { o->correlation_length = 0.0; });
  refused([](auto* o) { o->disparity_sigma = -1.0; });
  refused([](auto* o) { o->min_scale = 0.0; });
  refused([](auto* o) { o->max_scale = 1.0; });
  refused([](auto* o) { o->neighbours = 0; });
}

}  // namespace
}  // namespace planegraph
