#include "planegraph/segmentation/map_segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "planegraph/segmentation/planes_json.h"
#include "segmentation/vision_world.h"

namespace planegraph {
namespace {

// Ground of 30 x 24 m with a house on it, clear of the coordinate axes, where tiles begin.
RayWorld Farm() {
  RayWorld world;
  world.AddFace({17.0, 14.0, 0.0}, Eigen::Vector3d::UnitZ(), 12.0, 15.0);
  AddHouse({13.0, 15.0, 0.0}, {7.0, 5.0, 4.0}, 0.4, &world);
  return world;
}

MapSegmentationOptions OptionsFor(const Cloud& cloud, double tile = 64.0) {
  MapSegmentationOptions options;
  options.segmentation = VisionOptions(cloud);
  options.tile = tile;
  return options;
}

double DegreesBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

// Whether the plane is none of the world's.
bool IsBevel(const RayWorld& world, const PlaneSegment& plane) {
  return std::none_of(world.faces.begin(), world.faces.end(), [&](const Face& face) {
    return DegreesBetween(face.normal(), plane.plane.normal) < 3.0 &&
           std::abs(face.plane().SignedDistance(plane.centroid())) < 0.05;
  });
}

double Distance(const Face& face, const Eigen::Vector3d& place) {
  const Eigen::Vector3d d = place - face.centre;
  const double u = std::max(0.0, std::abs(face.u.dot(d)) - face.half_u);
  const double v = std::max(0.0, std::abs(face.v.dot(d)) - face.half_v);
  return std::hypot(u, v, face.normal().dot(d));
}

// Whether no other face is within a coarse cell, which would see both.
bool IsInner(const RayWorld& world, std::size_t face, const Eigen::Vector3d& place) {
  for (std::size_t f = 0; f < world.faces.size(); ++f) {
    if (f != face && Distance(world.faces[f], place) < 1.8) return false;
  }
  return true;
}

TEST(SegmentMap, FindsGroundWallsAndRoof) {
  const RayWorld farm = Farm();
  const Cloud cloud = SampleFaces(farm, {}, 1);
  const Segmentation found = SegmentMap(cloud, OptionsFor(cloud));
  // Cells across the edges of a house bevel them: these planes are narrow, and noisier.
  for (const PlaneSegment& plane : found.planes.planes) {
    if (!IsBevel(farm, plane)) continue;
    EXPECT_LT(plane.area, 10.0);
    EXPECT_GT(plane.thickness, 1.5 * found.noise.AlongNormal(0.0, 1.0));
  }
  for (std::size_t f = 0; f < farm.faces.size(); ++f) {
    const Plane truth = farm.faces[f].plane();
    const auto cost = [&](const PlaneSegment& p) {
      return (p.plane.normal - truth.normal).norm() + std::abs(truth.SignedDistance(p.centroid()));
    };
    const auto best =
        std::min_element(found.planes.planes.begin(), found.planes.planes.end(),
                         [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
    ASSERT_NE(best, found.planes.planes.end());
    EXPECT_LT(DegreesBetween(best->plane.normal, truth.normal), 0.5) << f;
    EXPECT_LT(std::abs(truth.SignedDistance(best->centroid())), 0.01) << f;
    EXPECT_NEAR(best->area / (4.0 * farm.faces[f].half_u * farm.faces[f].half_v), 1.0, 0.3) << f;
    EXPECT_EQ(best->orientation, Orientation::kSensor);
    EXPECT_EQ(best->source, CloudKind::kVision);
  }
}

TEST(SegmentMap, MeasuresTheNoise) {
  for (const double sigma : {0.01, 0.03, 0.06}) {
    const Cloud cloud = SampleFaces(Farm(), {.sigma = sigma}, 2);
    const Segmentation found = SegmentMap(cloud, OptionsFor(cloud));
    EXPECT_NEAR(found.noise.AlongNormal(0.0, 1.0) / sigma, 1.0, 0.15) << sigma;
    EXPECT_EQ(found.noise.per_metre, 0.0) << "a map has no range";
  }
}

// Of a cloud that is too large for it, the noise is measured on some of its tiles: on full ones.
TEST(SegmentMap, StraysLeaveTheNoiseAsItWas) {
  constexpr double kSigma = 0.03;
  const Cloud cloud = SampleFaces(Farm(), {.sigma = kSigma}, 2);
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<float> uniform(-500.0f, 500.0f);
  for (const double tile : {9.0, 25.6, 64.0}) {
    MapSegmentationOptions options = OptionsFor(cloud, tile);
    for (const std::size_t enough : {cloud.size() / 20, cloud.size() / 2, 2 * cloud.size()}) {
      options.noise_points = enough;
      Cloud strayed = cloud;
      for (int strays = 0; strays < 4; ++strays) {
        const double found = SegmentMap(strayed, options).noise.AlongNormal(0.0, 1.0);
        EXPECT_NEAR(found / kSigma, 1.0, 0.2) << tile << " " << enough << " " << strays;
        strayed.points.emplace_back(uniform(engine), uniform(engine), 0.0f);
        strayed.normals.push_back(Eigen::Vector3f::UnitZ());
      }
    }
  }
}

TEST(SegmentMap, LabelsCoverTheCloud) {
  std::vector<int> faces;
  const RayWorld farm = Farm();
  const Cloud cloud = SampleFaces(farm, {}, 3, &faces);
  for (const double tile : {9.0, 25.6, 64.0}) {
    const Segmentation found = SegmentMap(cloud, OptionsFor(cloud, tile));
    ASSERT_EQ(found.labels.size(), cloud.size());
    std::size_t labelled = 0, inner = 0, wrong = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (found.labels[i] < 0) continue;
      ASSERT_LT(found.labels[i], static_cast<int>(found.planes.planes.size()));
      ++labelled;
      const auto& plane = found.planes.planes[found.labels[i]].plane;
      if (!IsInner(farm, faces[i], cloud.Position(i))) continue;
      ++inner;
      wrong += DegreesBetween(plane.normal, farm.faces[faces[i]].normal()) > 5.0;
    }
    EXPECT_GT(labelled, 0.95 * cloud.size()) << tile;
    EXPECT_LT(wrong, 0.01 * inner) << tile;
  }
}

TEST(SegmentMap, IdsAreTheIndices) {
  const Cloud cloud = SampleFaces(Farm(), {}, 3);
  const Segmentation found = SegmentMap(cloud, OptionsFor(cloud, 9.0));
  EXPECT_GT(found.planes.planes.size(), 10u) << "tiles cut the ground";
  for (std::size_t k = 0; k < found.planes.planes.size(); ++k) {
    EXPECT_EQ(found.planes.planes[k].id, static_cast<int>(k));
  }
  for (const Patch& patch : found.planes.patches) {
    ASSERT_LT(patch.segment, static_cast<int>(found.planes.planes.size()));
    if (patch.segment < 0) continue;
    const Plane& plane = found.planes.planes[patch.segment].plane;
    EXPECT_LT(std::abs(plane.SignedDistance(patch.moments.mean)), 0.1);
  }
}

TEST(SegmentMap, ATileThatHoldsAllIsTheSegmentation) {
  const Cloud cloud = SampleFaces(Farm(), {}, 4);
  MapSegmentationOptions options = OptionsFor(cloud);
  options.segmentation.noise = NoiseModel{0.02, 0.0};
  const Segmentation direct = SegmentPlanes(cloud, options.segmentation);
  for (const double tile : {64.0, 300.0}) {
    options.tile = tile;
    const Segmentation whole = SegmentMap(cloud, options);
    EXPECT_EQ(FormatPlanes(whole.planes), FormatPlanes(direct.planes)) << tile;
    EXPECT_EQ(whole.labels, direct.labels);
  }
}

// Points in patches of each face, its border left out, and the largest distance of a patch's mean
// to it.
struct Cover {
  std::vector<double> points, heights;
};
Cover CoverOf(const RayWorld& world, const PlaneSet& planes) {
  Cover cover{std::vector<double>(world.faces.size()), std::vector<double>(world.faces.size())};
  for (const Patch& patch : planes.patches) {
    for (std::size_t f = 0; f < world.faces.size(); ++f) {
      const Plane plane = world.faces[f].plane();
      const double height = std::abs(plane.SignedDistance(patch.moments.mean));
      if (patch.normal.dot(plane.normal) < 0.98 || height > 0.2) continue;
      if (!IsInner(world, f, patch.moments.mean)) continue;
      cover.points[f] += patch.moments.count;
      cover.heights[f] = std::max(cover.heights[f], height);
    }
  }
  return cover;
}

TEST(SegmentMap, TilesKeepTheSurfaces) {
  const RayWorld farm = Farm();
  const Cloud cloud = SampleFaces(farm, {}, 4);
  MapSegmentationOptions options = OptionsFor(cloud);
  options.segmentation.noise = NoiseModel{0.02, 0.0};
  const Cover whole = CoverOf(farm, SegmentMap(cloud, options).planes);
  for (const double tile : {7.0, 12.8}) {
    options.tile = tile;
    const Cover tiled = CoverOf(farm, SegmentMap(cloud, options).planes);
    EXPECT_NEAR(tiled.points[0] / whole.points[0], 1.0, 0.03) << tile << ", the ground";
    for (std::size_t f = 0; f < farm.faces.size(); ++f) {
      EXPECT_LT(tiled.heights[f], 0.05) << tile << " " << f;
    }
  }
}

TEST(SegmentMap, EqualBytesForAnyNumberOfThreads) {
  const Cloud cloud = SampleFaces(Farm(), {}, 5);
  MapSegmentationOptions options = OptionsFor(cloud, 8.0);
  const Segmentation one = SegmentMap(cloud, options);
  for (const int threads : {0, 3}) {
    options.threads = threads;
    const Segmentation many = SegmentMap(cloud, options);
    EXPECT_EQ(FormatPlanes(many.planes), FormatPlanes(one.planes));
    EXPECT_EQ(many.labels, one.labels);
  }
}

// Turns the given share of the normals round.
void TurnNormals(double share, Cloud* cloud) {
  std::mt19937_64 engine(8);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (auto& normal : cloud->normals) {
    if (uniform(engine) < share) normal = -normal;
  }
}

// Whether the patch lies on a face and faces as it does; `side` -1: the other way.
bool FacesLikeItsFace(const RayWorld& world, const Patch& patch, double side) {
  return std::any_of(world.faces.begin(), world.faces.end(), [&](const Face& face) {
    return patch.normal.dot(side * face.normal()) > 0.3 &&
           std::abs(face.plane().SignedDistance(patch.moments.mean)) < 0.3;
  });
}

TEST(SegmentMap, NormalsFollowThePoints) {
  const RayWorld farm = Farm();
  Cloud cloud = SampleFaces(farm, {}, 6);
  TurnNormals(0.1, &cloud);
  for (const double side : {1.0, -1.0}) {
    const PlaneSet planes = SegmentMap(cloud, OptionsFor(cloud)).planes;
    ASSERT_FALSE(planes.patches.empty());
    std::size_t known = 0;
    for (const Patch& patch : planes.patches) {
      if (patch.orientation == Orientation::kUnknown) continue;
      ++known;
      EXPECT_TRUE(FacesLikeItsFace(farm, patch, side)) << patch.moments.mean.transpose();
    }
    EXPECT_GT(known, 0.95 * planes.patches.size());
    for (const PlaneSegment& plane : planes.planes) {
      EXPECT_TRUE(IsBevel(farm, plane) || plane.orientation == Orientation::kSensor);
    }
    TurnNormals(1.0, &cloud);
  }
}

TEST(SegmentMap, NoOrientationWithoutNormalsOrWithContradictoryOnes) {
  for (const bool has_normals : {false, true}) {
    Cloud cloud = SampleFaces(Farm(), {}, 7);
    TurnNormals(0.5, &cloud);
    if (!has_normals) cloud.normals.clear();
    const PlaneSet planes = SegmentMap(cloud, OptionsFor(cloud)).planes;
    ASSERT_FALSE(planes.planes.empty());
    for (const PlaneSegment& plane : planes.planes) {
      EXPECT_EQ(plane.orientation, Orientation::kUnknown);
    }
    const auto known =
        std::count_if(planes.patches.begin(), planes.patches.end(),
                      [](const Patch& patch) { return patch.orientation == Orientation::kSensor; });
    EXPECT_LE(known, 0.05 * planes.patches.size()) << "small cells agree by chance";
  }
}

TEST(SegmentMap, CloudsWithoutAPlane) {
  Cloud few;
  few.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const Cloud& cloud : {Cloud(), few}) {
    const Segmentation found = SegmentMap(cloud, OptionsFor(cloud));
    EXPECT_TRUE(found.planes.planes.empty());
    EXPECT_EQ(found.labels, std::vector<std::int32_t>(cloud.size(), -1));
  }
}

TEST(SegmentMap, AnOffsetChangesNothing) {
  Cloud cloud = SampleFaces(Farm(), {}, 9);
  const Segmentation near = SegmentMap(cloud, OptionsFor(cloud));
  cloud.offset = cloud.viewpoint = Eigen::Vector3d(4e5, 5.7e6, 120.0);
  const Segmentation far = SegmentMap(cloud, OptionsFor(cloud));
  EXPECT_EQ(near.labels, far.labels);
  EXPECT_EQ(far.planes.offset, cloud.offset);
}

TEST(VisionOptions, CellsGrowWithTheSpacingOfThePoints) {
  // Cells of nine points: three times the spacing, and so the square root of the density.
  std::vector<double> sizes;
  for (const double spacing : {0.06, 0.12}) {
    const Cloud cloud = SampleFaces(Farm(), {.spacing = spacing}, 10);
    sizes.push_back(VisionOptions(cloud).cell_size);
    EXPECT_NEAR(sizes.back() / (3.0 * spacing), 1.0, 0.15) << spacing;
  }
  EXPECT_NEAR(sizes[1] / sizes[0], 2.0, 0.1);
}

TEST(VisionOptions, CellsHaveBounds) {
  EXPECT_EQ(VisionOptions(SampleFaces(Farm(), {.spacing = 0.6}, 11)).cell_size, 0.5);
  RayWorld tile;
  tile.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 1.0, 1.0);
  EXPECT_EQ(VisionOptions(SampleFaces(tile, {.spacing = 0.01}, 11)).cell_size, 0.1);
  const double without_points = VisionOptions(Cloud()).cell_size;
  EXPECT_GE(without_points, 0.1);
  EXPECT_LE(without_points, 0.5);
}

TEST(VisionOptions, TheDensityOfManyPointsIsThatOfFew) {
  // Above 300,000 points only some are looked at.
  RayWorld field, patch;
  field.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 50.0, 50.0);
  patch.AddFace({0, 0, 0}, Eigen::Vector3d::UnitZ(), 15.0, 15.0);
  const double many = VisionOptions(SampleFaces(field, {.spacing = 0.1}, 12)).cell_size;
  const double few = VisionOptions(SampleFaces(patch, {.spacing = 0.1}, 12)).cell_size;
  EXPECT_NEAR(many / few, 1.0, 0.1);
}

TEST(PlanesOfMaps, RoundTripKeepsWhatIsKnownOfOrientations) {
  Cloud cloud = SampleFaces(Farm(), {.spacing = 0.25}, 13);
  TurnNormals(0.2, &cloud);  // near the limit: some patches know, some do not
  const PlaneSet before = SegmentMap(cloud, OptionsFor(cloud, 9.0)).planes;
  const PlaneSet after = ParsePlanes(FormatPlanes(before), "map");
  EXPECT_EQ(after.kind, CloudKind::kVision);
  EXPECT_TRUE(after.range_image.empty());
  ASSERT_EQ(after.patches.size(), before.patches.size());
  std::set<Orientation> kinds;
  for (std::size_t i = 0; i < before.patches.size(); ++i) {
    EXPECT_EQ(after.patches[i].orientation, before.patches[i].orientation) << i;
    kinds.insert(before.patches[i].orientation);
  }
  EXPECT_EQ(kinds.size(), 2u);
  EXPECT_EQ(FormatPlanes(after), FormatPlanes(before));
}

}  // namespace
}  // namespace planegraph
