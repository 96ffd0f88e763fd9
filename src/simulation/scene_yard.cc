#include <cmath>

#include "planegraph/simulation/mesh_parts.h"
#include "planegraph/simulation/terrain.h"
#include "simulation/layout.h"
#include "simulation/scenes.h"

namespace planegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kYardFoundation = -1.2;  // walls go so far below the floor
constexpr double kGateLine = 13.0;        // y of the hall's front

// South of the hall the ground falls and rises again; to the east there is a bank.
Terrain DrawTerrain(Random* random) {
  const double level = random->Uniform(3.0, 6.0), dip = random->Uniform(-9.0, -5.0);
  const double depth = random->Uniform(0.035, 0.05) * (level - dip);
  const double rise = random->Uniform(0.03, 0.05) * (dip + 36.0);
  const double bank = random->Uniform(9.0, 11.0), across = random->Uniform(-0.012, 0.012);
  Terrain terrain;
  terrain.y = {{-36.0, dip, level, 36.0}, {rise - depth, -depth, 0.0, 0.0}};
  terrain.x = {
      {-36.0, bank, 36.0},
      {-36.0 * across, bank * across, bank * across + random->Uniform(0.07, 0.1) * (36.0 - bank)}};
  return terrain;
}

struct YardPlan {
  Terrain terrain;
  Vector2d hall_low, hall_size;
  double hall_floor, gate;  // height of the floor, x of the gate's middle
  std::vector<Vector2d> path;
};

YardPlan DrawYardPlan(Random* random) {
  YardPlan plan;
  plan.terrain = DrawTerrain(random);
  plan.hall_size = {random->Uniform(14.0, 16.0), random->Uniform(13.0, 16.0)};
  plan.hall_low = {random->Uniform(-9.0, -7.0), kGateLine};
  plan.hall_floor = plan.terrain.MaxHeight(plan.hall_low, plan.hall_low + plan.hall_size) + 0.03;
  plan.gate = random->Uniform(-1.0, 1.0);
  const auto bend = [&] { return random->Uniform(-0.8, 0.8); };
  plan.path = {{-3.0 + bend(), -15.0}, {2.5 + bend(), -9.0}, {-2.0 + bend(), -2.0},
               {bend(), 5.0},          {plan.gate, 10.5},    {plan.gate, 15.5}};
  // Deep into the hall, but not to its far wall.
  const double deep = plan.hall_low.y() + plan.hall_size.y() - 3.0;
  plan.path.emplace_back(plan.gate + 2.0 + bend(), deep - 3.5);
  plan.path.emplace_back(plan.gate - 1.0 + bend(), deep);
  return plan;
}

void AddGateHall(MeshBuilder* builder, const YardPlan& plan, Random* random) {
  constexpr double kGateWidth = 4.0, kRamp = 2.0;
  Shell shell;
  shell.size = plan.hall_size;
  shell.bottom = kYardFoundation;
  shell.height = random->Uniform(4.6, 5.4);
  shell.gable = random->Uniform(1.8, 2.8);
  const double start = plan.gate - 0.5 * kGateWidth - plan.hall_low.x();
  shell.openings[0] = {{start, kGateWidth, 0.0, 3.6}};
  shell.openings[1] = {{2.0, 2.0, 1.4, 1.4}, {7.0, 2.0, 1.4, 1.4}};
  shell.openings[3] = {{4.0, 2.5, 1.2, 1.6}};
  const Rigid3 place = Upright({plan.hall_low.x(), plan.hall_low.y(), plan.hall_floor}, 0.0);
  AddShell(builder, place, shell);
  AddPitchedRoof(builder, place, shell, 0.5, 0.25);
  AddBox(builder, place, {0.05, 0.05, kYardFoundation},
         {shell.size.x() - 0.05, shell.size.y() - 0.05, 0.0});
  const Vector2d foot(plan.gate - 0.5 * kGateWidth - 0.2, kGateLine - kRamp);
  const double low = plan.terrain.Height(foot) - 0.02;
  AddRamp(builder, Upright({foot.x(), foot.y(), low}, 0.0), {kGateWidth + 0.4, kRamp + 0.06},
          (plan.hall_floor - low) * (kRamp + 0.06) / (kRamp + 0.05), -0.5);
}

void FurnishGateHall(MeshBuilder* builder, const YardPlan& plan, Layout* layout, Random* random) {
  const Vector2d low = plan.hall_low + Vector2d(2.0, 2.0);
  const Vector2d high = plan.hall_low + plan.hall_size - Vector2d(2.0, 2.0);
  for (int i = 0; i < 5; ++i) {
    const double radius = random->Uniform(0.6, 1.4), angle = random->Uniform(0.5, 1.0);
    const Vector2d half = radius * Vector2d(std::cos(angle), std::sin(angle));
    const double yaw = random->Uniform(-0.5, 0.5), height = random->Uniform(0.8, 2.4);
    const auto at = layout->Place(low, high, radius, random);
    if (!at) continue;
    AddBox(builder, Upright({at->x(), at->y(), plan.hall_floor}, yaw), {-half.x(), -half.y(), -0.2},
           {half.x(), half.y(), height});
  }
}

// A house with its middle at `center`, with windows on all sides and a door.
void AddHouse(MeshBuilder* builder, const Terrain& terrain, const Vector2d& center, double yaw,
              Random* random) {
  Shell shell;
  shell.size = {random->Uniform(7.5, 10.0), random->Uniform(5.0, 6.5)};
  shell.bottom = kYardFoundation;
  shell.height = random->Uniform(2.8, 3.8);
  shell.gable = random->Uniform(1.3, 2.4);
  for (int side = 0; side < 4; ++side) {
    const double length = shell.size[side % 2];
    shell.openings[side] = {{0.2 * length, 1.1, 1.0, 1.2}, {0.6 * length, 1.1, 1.0, 1.2}};
  }
  shell.openings[0].insert(shell.openings[0].begin() + 1,
                           Opening{0.2 * shell.size.x() + 1.6, 1.0, 0.15, 2.1});
  const Vector3d position(center.x(), center.y(), terrain.Height(center) + 0.1);
  const Rigid3 middle(Eigen::Quaterniond::Identity(),
                      {-0.5 * shell.size.x(), -0.5 * shell.size.y(), 0.0});
  const Rigid3 place = Upright(position, yaw) * middle;
  AddShell(builder, place, shell);
  AddPitchedRoof(builder, place, shell, random->Uniform(0.3, 0.6), 0.2);
}

void AddHouses(MeshBuilder* builder, const Terrain& terrain, Layout* layout, Random* random) {
  struct HouseLot {
    Vector2d center;
    double yaw;
  };
  const HouseLot lots[] = {{{-17.0, -9.5}, 1.57}, {{17.5, -11.0}, -1.57}, {{-17.5, 4.0}, 1.57},
                           {{17.5, 3.5}, -1.57},  {{-2.0, -25.5}, 3.14},  {{16.5, 18.0}, 0.0}};
  const int houses = 4 + random->Index(3);
  for (int i = 0; i < houses; ++i) {
    const Vector2d shift{random->Uniform(-1.0, 1.0), random->Uniform(-1.0, 1.0)};
    const Vector2d center = lots[i].center + shift;
    AddHouse(builder, terrain, center, lots[i].yaw + random->Uniform(-0.2, 0.2), random);
    layout->Occupy(center, 4.5);
  }
}

const Vector2d kYardLow(-13.5, -17.0), kYardHigh(14.0, 10.5);

void AddContainersAndWalls(MeshBuilder* builder, const Terrain& terrain, Layout* layout,
                           Random* random) {
  for (int i = 0; i < 5; ++i) {
    const bool container = i < 3;
    const double half = container ? 3.03 : random->Uniform(2.0, 3.5);
    const double yaw = random->Uniform(-3.14, 3.14), height = random->Uniform(0.8, 1.3);
    const auto at = layout->Place(kYardLow, kYardHigh, half + 0.3, random);
    if (!at) continue;
    const Rigid3 place = OnGround(terrain, *at, yaw);
    if (container) {
      AddBox(builder, place, {-half, -1.22, -0.6}, {half, 1.22, 2.5});
    } else {
      const Rigid3 middle(Eigen::Quaterniond::Identity(), {-half, -0.12, 0.0});
      AddWall(builder, place * middle, Wall{2.0 * half, 0.24, -0.6, height, {}});
    }
  }
}

void AddClutter(MeshBuilder* builder, const Terrain& terrain, Layout* layout, Random* random) {
  const auto scatter = [&](int count, double smallest, double largest, const auto& add) {
    for (int i = 0; i < count; ++i) {
      const double radius = random->Uniform(smallest, largest);
      const auto at = layout->Place(kYardLow, kYardHigh, radius, random);
      if (at) add(OnGround(terrain, *at, 0.0), radius);
    }
  };
  const Rigid3 sunk(Eigen::Quaterniond::Identity(), {0.0, 0.0, -0.4});
  scatter(1, 1.0, 1.4, [&](const Rigid3& place, double radius) {
    AddCylinder(builder, place * sunk, radius, random->Uniform(2.5, 3.5));
  });
  scatter(5, 0.06, 0.15, [&](const Rigid3& place, double radius) {
    AddCylinder(builder, place * sunk, radius, random->Uniform(4.0, 6.5));
  });
  scatter(3, 0.4, 0.8, [&](const Rigid3& place, double radius) {
    AddSphere(builder, place * Vector3d(0.0, 0.0, 0.8 * radius), radius);
  });
  scatter(6, 0.5, 1.1, [&](const Rigid3& place, double radius) {
    AddBush(builder, place * Vector3d(0.0, 0.0, 0.8 * radius), radius, random);
  });
}

}  // namespace

Scene BuildYard(Random* random) {
  const YardPlan plan = DrawYardPlan(random);
  MeshBuilder builder;
  AddTerrain(&builder, plan.terrain);
  AddGateHall(&builder, plan, random);
  Layout layout(plan.path, 1.0);
  AddHouses(&builder, plan.terrain, &layout, random);
  AddContainersAndWalls(&builder, plan.terrain, &layout, random);
  AddClutter(&builder, plan.terrain, &layout, random);
  FurnishGateHall(&builder, plan, &layout, random);
  Scene scene;
  scene.mesh = builder.mesh();
  scene.drives = {{"robot1", plan.path, 9}};
  scene.probe_height = 3.0;
  scene.area_low = {-23.0, -28.0};
  scene.area_high = {23.0, 30.0};
  return scene;
}

}  // namespace planegraph
