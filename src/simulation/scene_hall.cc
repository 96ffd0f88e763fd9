#include <array>

#include "planegraph/simulation/mesh_parts.h"
#include "simulation/layout.h"
#include "simulation/scenes.h"

namespace planegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The plan: the hall fills y in [0, split], three rooms lie side by side in [split, size.y].
struct HallPlan {
  Vector2d size;
  double height, split, room_height;
  std::array<double, 2> walls;  // x of the walls between the rooms
  std::array<double, 3> doors;  // x of the doors from the hall into the rooms
  double inner_door;            // y of the door between the first and the second room
};
constexpr double kPartition = 0.16, kDoorWidth = 1.4, kDoorHeight = 2.1, kShell = 0.3;

HallPlan DrawHallPlan(Random* random) {
  HallPlan plan{};
  plan.size = {random->Uniform(26.0, 31.0), random->Uniform(17.5, 20.0)};
  plan.height = random->Uniform(5.0, 6.5);
  plan.split = plan.size.y() - random->Uniform(5.0, 6.0);
  plan.room_height = random->Uniform(2.8, 3.3);
  plan.walls = {plan.size.x() * random->Uniform(0.30, 0.36),
                plan.size.x() * random->Uniform(0.63, 0.69)};
  const double edges[] = {0.0, plan.walls[0], plan.walls[1], plan.size.x()};
  for (int i = 0; i < 3; ++i) {
    plan.doors[i] = 0.5 * (edges[i] + edges[i + 1]) + random->Uniform(-0.8, 0.8);
  }
  plan.inner_door = 0.5 * (plan.split + plan.size.y()) + random->Uniform(-0.4, 0.4);
  return plan;
}

// Around the columns, into the second room, through the first one and back to the start.
std::vector<Vector2d> Loop(const HallPlan& plan) {
  const double east = plan.size.x() - 3.5, north = plan.split - 2.2;
  return {{4.0, 2.8},
          {east, 2.8},
          {east, north},
          {plan.doors[1], north},
          {plan.doors[1], plan.inner_door},
          {plan.doors[0], plan.inner_door},
          {plan.doors[0], north},
          {3.2, north},
          {3.2, 3.8}};
}

Shell OuterWalls(const HallPlan& plan) {
  Shell shell;
  shell.size = plan.size;
  shell.thickness = kShell;
  shell.bottom = -0.4;
  shell.height = plan.height;
  for (int i = 0; i < 4; ++i) {
    shell.openings[0].push_back({plan.size.x() * (0.16 + 0.2 * i), 2.4, 3.0, 1.2});
  }
  shell.openings[1] = {{2.0, 3.6, 0.0, 3.8}};
  for (int i = 2; i >= 0; --i) {
    shell.openings[2].push_back({plan.size.x() - plan.doors[i] - 0.8, 1.6, 0.9, 1.3});
  }
  return shell;
}

void AddSlab(MeshBuilder* builder, const Vector3d& low, const Vector3d& high) {
  AddBox(builder, Rigid3(), low, high);
}

void AddRooms(MeshBuilder* builder, const HallPlan& plan) {
  const double inside = plan.size.x() - kShell + 0.05, depth = plan.size.y() - plan.split;
  Wall front{inside - kShell + 0.05, kPartition, 0.0, plan.height + 0.02, {}};
  const double start = kShell - 0.05;
  for (const double door : plan.doors) {
    front.openings.push_back({door - start - 0.5 * kDoorWidth, kDoorWidth, 0.0, kDoorHeight});
  }
  AddWall(builder, Upright({start, plan.split - kPartition, 0.0}, 0.0), front);
  for (int i = 0; i < 2; ++i) {
    Wall between{depth - kShell + 0.1, kPartition, 0.0, plan.room_height + 0.05, {}};
    const double door = plan.inner_door - plan.split + 0.05;
    if (i == 0) {
      between.openings = {{door - 0.5 * kDoorWidth, kDoorWidth, 0.0, kDoorHeight}};
    }
    AddWall(builder, Upright({plan.walls[i], plan.split - 0.05, 0.0}, 1.5707963267948966), between);
  }
  AddSlab(builder, {start, plan.split - 0.05, plan.room_height},
          {inside, plan.size.y() - kShell + 0.05, plan.room_height + 0.2});
}

void AddColumnsAndBeams(MeshBuilder* builder, const HallPlan& plan, Layout* layout,
                        Random* random) {
  for (int i = 0; i < 4; ++i) {
    const double x = plan.size.x() * (0.22 + 0.18 * i) + random->Uniform(-0.2, 0.2);
    const double depth = random->Uniform(0.3, 0.7);
    AddSlab(builder, {x - 0.15, kShell - 0.05, plan.height - depth},
            {x + 0.15, plan.split - kPartition + 0.05, plan.height + 0.1});
    for (const double share : {0.42, 0.62}) {
      const Vector2d at(x, plan.split * share + random->Uniform(-0.2, 0.2));
      const double half = random->Uniform(0.18, 0.28);
      AddSlab(builder, {at.x() - half, at.y() - half, -0.1},
              {at.x() + half, at.y() + half, plan.height});
      layout->Occupy(at, 1.5 * half);
    }
  }
}

void AddMachine(MeshBuilder* builder, const Vector2d& at, double radius, Random* random) {
  const Rigid3 place = Upright({at.x(), at.y(), 0.0}, random->Uniform(-0.6, 0.6));
  const double angle = random->Uniform(0.5, 1.0);
  const Vector2d half = radius * Vector2d(std::cos(angle), std::sin(angle));
  const double height = random->Uniform(0.7, 2.2);
  AddBox(builder, place, {-half.x(), -half.y(), -0.1}, {half.x(), half.y(), height});
  const double inset = random->Uniform(0.2, 0.5), top = height + random->Uniform(0.3, 0.9);
  AddBox(builder, place, {-half.x() * inset, -half.y() * 0.7, height - 0.1},
         {half.x() * 0.8, half.y() * inset, top});
}

// An inclined belt, for planes that are neither upright nor level.
void AddConveyor(MeshBuilder* builder, const Vector2d& at, Random* random) {
  const Rigid3 place = Upright({at.x(), at.y(), 0.9}, random->Uniform(-0.5, 0.5));
  const Rigid3 incline(Eigen::Quaterniond(Eigen::AngleAxisd(-0.4, Vector3d::UnitY())),
                       Vector3d::Zero());
  AddBox(builder, place * incline, {-1.9, -0.5, -0.15}, {1.9, 0.5, 0.0});
}

void AddFurniture(MeshBuilder* builder, const HallPlan& plan, Layout* layout, Random* random) {
  const Vector2d low(2.0, 4.2), high(plan.size.x() - 5.0, plan.split - 3.6);
  if (const auto at = layout->Place(low, high, 2.0, random)) AddConveyor(builder, *at, random);
  for (int i = 0; i < 6; ++i) {
    const double radius = random->Uniform(0.6, 1.3);
    if (const auto at = layout->Place(low, high, radius, random)) {
      AddMachine(builder, *at, radius, random);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const double radius = random->Uniform(0.3, 0.6);
    if (const auto at = layout->Place(low, high, radius, random)) {
      AddCylinder(builder, Upright({at->x(), at->y(), 0.0}, 0.0), radius,
                  random->Uniform(1.0, 2.5));
    }
  }
}

// Cupboards along the rooms' outer wall.
void AddCupboards(MeshBuilder* builder, const HallPlan& plan, Random* random) {
  const double edges[] = {kShell, plan.walls[0], plan.walls[1], plan.size.x() - kShell};
  for (int i = 0; i < 3; ++i) {
    const double width = random->Uniform(1.0, 2.0), depth = random->Uniform(0.4, 0.6);
    const double x = edges[i] + random->Uniform(0.3, 0.6), y = plan.size.y() - kShell;
    AddSlab(builder, {x, y - depth, -0.1}, {x + width, y + 0.05, random->Uniform(0.8, 2.0)});
  }
}

}  // namespace

Scene BuildHall(Random* random) {
  const HallPlan plan = DrawHallPlan(random);
  MeshBuilder builder;
  AddSlab(&builder, {-40.0, -40.0, -1.0}, {plan.size.x() + 40.0, plan.size.y() + 40.0, -0.2});
  AddSlab(&builder, {0.05, 0.05, -0.4}, {plan.size.x() - 0.05, plan.size.y() - 0.05, 0.0});
  const Shell shell = OuterWalls(plan);
  AddShell(&builder, Rigid3(), shell);
  AddFlatRoof(&builder, Rigid3(), shell, 0.5, 0.3);
  AddRooms(&builder, plan);
  Scene scene;
  scene.drives = {{"robot1", Loop(plan), 16}};
  scene.area_low = {-5.0, -5.0};
  scene.area_high = plan.size + Vector2d(5.0, 5.0);
  Layout layout(scene.drives[0].path, 0.9);
  AddColumnsAndBeams(&builder, plan, &layout, random);
  AddFurniture(&builder, plan, &layout, random);
  AddCupboards(&builder, plan, random);
  scene.mesh = builder.mesh();
  return scene;
}

}  // namespace planegraph
