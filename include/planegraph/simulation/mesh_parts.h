#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/simulation/labelled_mesh.h"
#include "planegraph/simulation/random.h"

namespace planegraph {

/// Parametric parts of buildings and yards. Each is placed by world_from_part; lengths in metres.

/// An upright placement: turned by `yaw` (radians) about z.
Rigid3 Upright(const Eigen::Vector3d& position, double yaw);

/// A box between two corners of its own frame, with six planes.
void AddBox(MeshBuilder* builder, const Rigid3& world_from_box, const Eigen::Vector3d& low,
            const Eigen::Vector3d& high);

/// A door, gate or window in a wall.
struct Opening {
  double start = 0.0;   ///< along the wall, from its left end as seen from outside
  double width = 1.0;   ///< along the wall
  double sill = 0.0;    ///< height of the lower edge; 0: a door, open down to the wall's bottom
  double height = 2.0;  ///< of the opening itself
};

/// A free-standing wall along x from 0 to `length`, y from 0 to `thickness`, z from `bottom` to
/// `height`. Each side is one plane however many openings it has; openings are in order and apart.
struct Wall {
  double length = 4.0, thickness = 0.2, bottom = 0.0, height = 3.0;
  std::vector<Opening> openings;
};
void AddWall(MeshBuilder* builder, const Rigid3& world_from_wall, const Wall& wall);

/// Four walls around [0, size.x] x [0, size.y]. Side 0 runs along x at y = 0, the others follow
/// counterclockwise, and openings count from the side's start. With `gable` > 0 the sides 1 and 3
/// rise by so much in their middle (the ridge runs along x). No floor, no roof.
struct Shell {
  Eigen::Vector2d size{8.0, 6.0};
  double thickness = 0.3, bottom = 0.0, height = 3.0, gable = 0.0;
  std::array<std::vector<Opening>, 4> openings;
};
void AddShell(MeshBuilder* builder, const Rigid3& world_from_shell, const Shell& shell);

/// Two roof slabs of the given thickness that rest on a shell with gable > 0 (pitch up to 45
/// degrees), with overhanging eaves.
void AddPitchedRoof(MeshBuilder* builder, const Rigid3& world_from_shell, const Shell& shell,
                    double overhang, double thickness);
/// A horizontal slab that rests on a shell.
void AddFlatRoof(MeshBuilder* builder, const Rigid3& world_from_shell, const Shell& shell,
                 double overhang, double thickness);

/// A wedge over [0, size.x] x [0, size.y] that rises along y from z = 0 to z = rise, with closed
/// sides that go down to z = bottom.
void AddRamp(MeshBuilder* builder, const Rigid3& world_from_ramp, const Eigen::Vector2d& size,
             double rise, double bottom);

/// An upright cylinder on the origin of its frame. The jacket is not planar; the lid is.
void AddCylinder(MeshBuilder* builder, const Rigid3& world_from_cylinder, double radius,
                 double height);
void AddSphere(MeshBuilder* builder, const Eigen::Vector3d& center, double radius);
/// Leaves: small triangles at random in a ball.
void AddBush(MeshBuilder* builder, const Eigen::Vector3d& center, double radius, Random* random);

}  // namespace planegraph
