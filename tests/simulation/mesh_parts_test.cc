#include "planegraph/simulation/mesh_parts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "planegraph/simulation/terrain.h"

namespace planegraph {
namespace {

using Eigen::Vector3d;

double TriangleArea(const LabelledMesh& mesh, std::size_t i) {
  const Eigen::Vector3i& t = mesh.triangles[i];
  return 0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                   .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                   .norm();
}

double LabelArea(const LabelledMesh& mesh, int label) {
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.labels[i] == label) area += TriangleArea(mesh, i);
  }
  return area;
}

void ExpectFacesOnTheirPlanes(const LabelledMesh& mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.labels[i] == kNotPlanar) continue;
    const Plane& plane = mesh.planes[mesh.labels[i]];
    EXPECT_NEAR(plane.normal.norm(), 1.0, 1e-12);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(plane.SignedDistance(mesh.vertices[mesh.triangles[i][k]]), 0.0, 1e-9);
    }
    EXPECT_GT(TriangleArea(mesh, i), 0.0);
  }
}

const Rigid3 kPlace = Upright({3.0, -2.0, 0.5}, 0.7);

TEST(MeshPartsTest, BoxHasSixPlanesThatPointOutwards) {
  MeshBuilder builder;
  AddBox(&builder, kPlace, {0.0, 0.0, 0.0}, {1.0, 2.0, 3.0});
  ExpectFacesOnTheirPlanes(builder.mesh());
  ASSERT_EQ(builder.mesh().planes.size(), 6u);
  const Vector3d center = kPlace * Vector3d(0.5, 1.0, 1.5);
  double area = 0.0;
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(builder.mesh().planes[i].SignedDistance(center), -0.4);
    area += LabelArea(builder.mesh(), i);
  }
  EXPECT_NEAR(area, 2.0 * (2.0 + 3.0 + 6.0), 1e-9);
}

TEST(MeshPartsTest, WallSidesAreOnePlaneEachLessTheOpenings) {
  MeshBuilder builder;
  AddWall(&builder, kPlace, {6.0, 0.25, -0.5, 3.0, {{1.0, 1.0, 0.0, 2.0}, {3.0, 1.5, 1.0, 1.2}}});
  const LabelledMesh& mesh = builder.mesh();
  ExpectFacesOnTheirPlanes(mesh);
  const double side = 6.0 * 3.5 - 2.5 - 1.8;
  EXPECT_NEAR(LabelArea(mesh, 0), side, 1e-9);
  EXPECT_NEAR(LabelArea(mesh, 1), side, 1e-9);
  EXPECT_NEAR((mesh.planes[0].normal + mesh.planes[1].normal).norm(), 0.0, 1e-12);
  EXPECT_NEAR(mesh.planes[0].distance + mesh.planes[1].distance, 0.25, 1e-12);
  // Two sides, three faces of the door, four of the window, both ends and the top.
  EXPECT_EQ(mesh.planes.size(), 2u + 3u + 4u + 3u);
}

TEST(MeshPartsTest, PitchedRoofRestsOnTheGables) {
  Shell shell;
  shell.gable = 1.5;
  MeshBuilder builder;
  AddShell(&builder, kPlace, shell);
  AddPitchedRoof(&builder, kPlace, shell, 0.4, 0.2);
  ExpectFacesOnTheirPlanes(builder.mesh());
  const Vector3d eaves = kPlace * Vector3d(1.0, 0.0, 3.0), ridge = kPlace * Vector3d(2.0, 3.0, 4.5);
  int through_ridge = 0, through_eaves = 0;
  for (const Plane& plane : builder.mesh().planes) {
    const bool inclined = std::abs(plane.normal.z()) > 0.1 && plane.normal.z() < 0.0;
    if (!inclined || std::abs(plane.SignedDistance(ridge)) > 1e-9) continue;
    ++through_ridge;
    EXPECT_NEAR(plane.normal.z(), -std::cos(std::atan(0.5)), 1e-12);
    through_eaves += std::abs(plane.SignedDistance(eaves)) < 1e-9;
  }
  EXPECT_EQ(through_ridge, 2) << "the undersides of both slabs meet in the ridge";
  EXPECT_EQ(through_eaves, 1) << "the one over side 0";
}

TEST(MeshPartsTest, CurvedThingsHaveNoPlanesButTheirLids) {
  MeshBuilder builder;
  Random random(1);
  AddSphere(&builder, {0.0, 0.0, 1.0}, 0.5);
  AddBush(&builder, {4.0, 0.0, 1.0}, 0.5, &random);
  EXPECT_TRUE(builder.mesh().planes.empty());
  AddCylinder(&builder, kPlace, 0.4, 2.0);
  ASSERT_EQ(builder.mesh().planes.size(), 1u);
  EXPECT_NEAR(builder.mesh().planes[0].distance, 2.5, 1e-12);
}

TEST(TerrainTest, IsPlanarBetweenTheKnots) {
  const Terrain terrain{{{-10.0, 2.0, 10.0}, {0.0, 0.12, 0.9}}, {{-5.0, 5.0}, {0.3, 0.0}}};
  MeshBuilder builder;
  AddTerrain(&builder, terrain);
  ExpectFacesOnTheirPlanes(builder.mesh());
  ASSERT_EQ(builder.mesh().planes.size(), 2u);
  const Eigen::Vector2d at(6.0, 1.0);
  EXPECT_NEAR(terrain.Height(at), 0.12 + 0.5 * 0.78 + 0.4 * 0.3, 1e-12);
  EXPECT_NEAR(builder.mesh().planes[1].SignedDistance({6.0, 1.0, terrain.Height(at)}), 0.0, 1e-12);
  EXPECT_NEAR(terrain.MaxHeight({0.0, 0.0}, {6.0, 5.0}), 0.12 + 0.39 + 0.15, 1e-12);
}

}  // namespace
}  // namespace planegraph
