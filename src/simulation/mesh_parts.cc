#include "planegraph/simulation/mesh_parts.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

namespace planegraph {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.141592653589793;

std::vector<Vector3d> Place(const Rigid3& world_from_part, std::vector<Vector3d> corners) {
  for (Vector3d& corner : corners) corner = world_from_part * corner;
  return corners;
}

// A rectangle in x and z at y = const. of a wall's frame, seen from -y. Empty ones are left out.
struct Rectangle {
  double x0, x1, z0, z1;
};

void AddUpright(MeshBuilder* builder, const Rigid3& world_from_wall, const Rectangle& r, double y,
                int label) {
  if (r.x1 <= r.x0 || r.z1 <= r.z0) return;
  builder->AddPolygon(Place(world_from_wall, {Vector3d(r.x0, y, r.z0), Vector3d(r.x1, y, r.z0),
                                              Vector3d(r.x1, y, r.z1), Vector3d(r.x0, y, r.z1)}),
                      label);
}

// One side of a wall: the rectangle less its openings.
void AddPerforated(MeshBuilder* builder, const Rigid3& world_from_wall, const Rectangle& r,
                   double y, const std::vector<Opening>& openings, int label) {
  double x = r.x0;
  for (const Opening& o : openings) {
    const double end = o.start + o.width;
    AddUpright(builder, world_from_wall, {x, o.start, r.z0, r.z1}, y, label);
    if (o.sill > 0.0) AddUpright(builder, world_from_wall, {o.start, end, r.z0, o.sill}, y, label);
    AddUpright(builder, world_from_wall, {o.start, end, o.sill + o.height, r.z1}, y, label);
    x = end;
  }
  AddUpright(builder, world_from_wall, {x, r.x1, r.z0, r.z1}, y, label);
}

// The faces inside an opening, between the wall's two sides at y = 0 and y = depth.
void AddReveal(MeshBuilder* builder, const Rigid3& world_from_wall, const Opening& o, double depth,
               double bottom) {
  const double x0 = o.start, x1 = o.start + o.width, z1 = o.sill + o.height;
  const double z0 = o.sill > 0.0 ? o.sill : bottom;
  const auto face = [&](double xa, double za, double xb, double zb) {
    builder->AddFace(Place(world_from_wall, {Vector3d(xa, 0, za), Vector3d(xa, depth, za),
                                             Vector3d(xb, depth, zb), Vector3d(xb, 0, zb)}));
  };
  face(x0, z0, x0, z1);
  face(x1, z1, x1, z0);
  face(x0, z1, x1, z1);
  if (o.sill > 0.0) face(x1, z0, x0, z0);
}

int AddSide(MeshBuilder* builder, const Rigid3& world_from_wall, double y, double outward) {
  const Vector3d normal = world_from_wall.rotation * Vector3d(0.0, outward, 0.0);
  return builder->AddPlane({normal, normal.dot(world_from_wall * Vector3d(0.0, y, 0.0))});
}

Rigid3 WorldFromSide(const Rigid3& world_from_shell, const Shell& shell, int side) {
  const Eigen::Vector2d size = shell.size;
  const Vector3d corners[] = {
      {0.0, 0.0, 0.0}, {size.x(), 0.0, 0.0}, {size.x(), size.y(), 0.0}, {0.0, size.y(), 0.0}};
  return world_from_shell * Upright(corners[side], 0.5 * kPi * side);
}

// Height that a pitched roof's underside gains per metre from the eaves inwards.
double Slope(const Shell& shell) { return 2.0 * shell.gable / shell.size.y(); }

// The outer (inset 0) or the inner (inset = thickness) face of one side. The inner one is higher by
// what the roof has risen until there.
void AddShellFace(MeshBuilder* builder, const Rigid3& world_from_side, const Shell& shell, int side,
                  double inset) {
  const double length = side % 2 == 0 ? shell.size.x() : shell.size.y();
  const double top = shell.height + inset * Slope(shell);
  const int label = AddSide(builder, world_from_side, inset, inset > 0.0 ? 1.0 : -1.0);
  AddPerforated(builder, world_from_side, {inset, length - inset, shell.bottom, top}, inset,
                shell.openings[side], label);
  if (shell.gable <= 0.0 || side % 2 == 0) return;
  builder->AddPolygon(
      Place(world_from_side, {Vector3d(inset, inset, top), Vector3d(length - inset, inset, top),
                              Vector3d(0.5 * length, inset, shell.height + shell.gable)}),
      label);
}

Vector3d OnSphere(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

}  // namespace

Rigid3 Upright(const Vector3d& position, double yaw) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ())), position};
}

void AddBox(MeshBuilder* builder, const Rigid3& world_from_box, const Vector3d& low,
            const Vector3d& high) {
  const auto corner = [&](int i) {
    return Vector3d(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                    i & 4 ? high.z() : low.z());
  };
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& face : kFaces) {
    builder->AddFace(Place(world_from_box,
                           {corner(face[0]), corner(face[1]), corner(face[2]), corner(face[3])}));
  }
}

void AddWall(MeshBuilder* builder, const Rigid3& world_from_wall, const Wall& wall) {
  const Rectangle all{0.0, wall.length, wall.bottom, wall.height};
  for (const double y : {0.0, wall.thickness}) {
    const int label = AddSide(builder, world_from_wall, y, y > 0.0 ? 1.0 : -1.0);
    AddPerforated(builder, world_from_wall, all, y, wall.openings, label);
  }
  for (const Opening& o : wall.openings)
    AddReveal(builder, world_from_wall, o, wall.thickness, wall.bottom);
  const double l = wall.length, t = wall.thickness, a = wall.bottom, b = wall.height;
  const auto face = [&](std::vector<Vector3d> corners) {
    builder->AddFace(Place(world_from_wall, std::move(corners)));
  };
  face({{0, t, a}, {0, 0, a}, {0, 0, b}, {0, t, b}});
  face({{l, 0, a}, {l, t, a}, {l, t, b}, {l, 0, b}});
  face({{0, 0, b}, {l, 0, b}, {l, t, b}, {0, t, b}});
}

void AddShell(MeshBuilder* builder, const Rigid3& world_from_shell, const Shell& shell) {
  for (int side = 0; side < 4; ++side) {
    const Rigid3 world_from_side = WorldFromSide(world_from_shell, shell, side);
    AddShellFace(builder, world_from_side, shell, side, 0.0);
    AddShellFace(builder, world_from_side, shell, side, shell.thickness);
    for (const Opening& o : shell.openings[side]) {
      AddReveal(builder, world_from_side, o, shell.thickness, shell.bottom);
    }
  }
}

void AddPitchedRoof(MeshBuilder* builder, const Rigid3& world_from_shell, const Shell& shell,
                    double overhang, double thickness) {
  const double angle = std::atan(Slope(shell));
  const double length = 0.5 * shell.size.y() / std::cos(angle);
  const Eigen::Quaterniond pitch(Eigen::AngleAxisd(angle, Vector3d::UnitX()));
  for (const int side : {0, 2}) {
    Rigid3 world_from_slab = WorldFromSide(world_from_shell, shell, side);
    world_from_slab = world_from_slab * Rigid3(pitch, Vector3d(0.0, 0.0, shell.height));
    // Beyond the ridge by so much that the upper faces meet; the lower edge hides in the other
    // slab.
    const double top = length + thickness * std::tan(angle);
    AddBox(builder, world_from_slab, {-overhang, -overhang, 0.0},
           {shell.size.x() + overhang, top, thickness});
  }
}

void AddFlatRoof(MeshBuilder* builder, const Rigid3& world_from_shell, const Shell& shell,
                 double overhang, double thickness) {
  AddBox(builder, world_from_shell, {-overhang, -overhang, shell.height},
         {shell.size.x() + overhang, shell.size.y() + overhang, shell.height + thickness});
}

void AddRamp(MeshBuilder* builder, const Rigid3& world_from_ramp, const Eigen::Vector2d& size,
             double rise, double bottom) {
  const double x = size.x(), y = size.y();
  const auto face = [&](std::vector<Vector3d> corners) {
    builder->AddFace(Place(world_from_ramp, std::move(corners)));
  };
  face({{0, 0, 0}, {x, 0, 0}, {x, y, rise}, {0, y, rise}});
  face({{0, 0, bottom}, {0, 0, 0}, {0, y, rise}, {0, y, bottom}});
  face({{x, 0, bottom}, {x, y, bottom}, {x, y, rise}, {x, 0, 0}});
  face({{0, 0, bottom}, {x, 0, bottom}, {x, 0, 0}, {0, 0, 0}});
}

void AddCylinder(MeshBuilder* builder, const Rigid3& world_from_cylinder, double radius,
                 double height) {
  constexpr int kSegments = 72;
  std::vector<Vector3d> lid(kSegments);
  for (int i = 0; i < kSegments; ++i) {
    lid[i] = radius * OnSphere(2.0 * kPi * i / kSegments, 0.0) + height * Vector3d::UnitZ();
  }
  builder->AddFace(Place(world_from_cylinder, lid));
  for (int i = 0; i < kSegments; ++i) {
    const Vector3d a = lid[i], b = lid[(i + 1) % kSegments];
    const Vector3d down(0.0, 0.0, -height);
    builder->AddPolygon(Place(world_from_cylinder, {a + down, b + down, b, a}), kNotPlanar);
  }
}

void AddSphere(MeshBuilder* builder, const Vector3d& center, double radius) {
  constexpr int kRings = 24, kSegments = 48;
  const auto at = [&](int ring, int segment) -> Vector3d {
    return center +
           radius * OnSphere(2.0 * kPi * segment / kSegments, kPi * ring / kRings - 0.5 * kPi);
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int i = 0; i < kSegments; ++i) {
      builder->AddPolygon({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)},
                          kNotPlanar);
    }
  }
}

void AddBush(MeshBuilder* builder, const Vector3d& center, double radius, Random* random) {
  const int leaves = static_cast<int>(600.0 * radius * radius);
  const auto within = [&](const Vector3d& middle, double size) -> Vector3d {
    const double azimuth = random->Uniform(0.0, 2.0 * kPi);
    const double elevation = std::asin(random->Uniform(-1.0, 1.0));
    return middle + size * std::cbrt(random->Uniform()) * OnSphere(azimuth, elevation);
  };
  for (int i = 0; i < leaves; ++i) {
    const Vector3d leaf = within(center, radius);
    const Vector3d a = within(leaf, 0.08), b = within(leaf, 0.08), c = within(leaf, 0.08);
    builder->AddPolygon({a, b, c}, kNotPlanar);
  }
}

}  // namespace planegraph
