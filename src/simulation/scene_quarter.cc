#include <algorithm>
#include <cmath>

#include "planegraph/simulation/mesh_parts.h"
#include "planegraph/simulation/terrain.h"
#include "simulation/layout.h"
#include "simulation/scenes.h"

namespace planegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kQuarterFoundation = -2.0;  // walls go so far below the floor
constexpr double kHalfPi = 1.5707963267948966;
constexpr double kWestStreet = -14.0, kEastStreet = 14.0;  // x of the streets' middles

// Two streets run from south to north, between them a block with a hall in its north, at their
// southern ends a square. The ground is level about the hall, falls to the square, and rises to the
// west.
struct QuarterPlan {
  Terrain terrain;
  Vector2d hall_low, hall_size;
  double hall_floor, gate;  // height of the floor, y of the middle of the gate to the east
};

QuarterPlan DrawQuarterPlan(Random* random) {
  QuarterPlan plan;
  const double fall = random->Uniform(0.03, 0.045), rise = random->Uniform(0.02, 0.035);
  const double level = random->Uniform(0.0, 2.5), square = random->Uniform(-17.0, -15.0);
  plan.terrain.y = {{-36.0, square, level, 36.0},
                    {-fall * (level - square), -fall * (level - square), 0.0, 0.0}};
  plan.terrain.x = {{-36.0, -9.5, 36.0}, {26.5 * rise, 0.0, 0.0}};
  plan.hall_low = {random->Uniform(-8.5, -7.0), random->Uniform(4.0, 5.5)};
  plan.hall_size = {random->Uniform(8.0, 8.8) - plan.hall_low.x(), random->Uniform(15.0, 18.0)};
  plan.hall_floor = 0.08;
  plan.gate = plan.hall_low.y() + plan.hall_size.y() * random->Uniform(0.4, 0.6);
  return plan;
}

// ugv1 goes down the west street, ugv2 up the east street and into the hall.
std::vector<Drive> DrawDrives(const QuarterPlan& plan, Random* random) {
  const auto bend = [&] { return random->Uniform(-0.8, 0.8); };
  std::vector<Vector2d> west, east;
  for (const double y : {23.0, 11.0, -1.0, -13.0}) west.emplace_back(kWestStreet + bend(), y);
  for (const double y : {-6.0, 1.0, plan.gate - 5.0}) east.emplace_back(kEastStreet + bend(), y);
  const double door = plan.hall_low.x() + plan.hall_size.x();
  east.emplace_back(door + 3.0, plan.gate);
  east.emplace_back(door - 2.0, plan.gate);
  east.emplace_back(plan.hall_low.x() + 7.0, plan.gate + 2.0 + bend());
  east.emplace_back(plan.hall_low.x() + 3.5, plan.gate + bend());
  return {{"ugv1", west, 8}, {"ugv2", east, 8}};
}

void AddRoof(MeshBuilder* builder, const Rigid3& place, const Shell& shell, Random* random) {
  const double overhang = random->Uniform(0.2, 0.6), thickness = random->Uniform(0.2, 0.35);
  if (shell.gable > 0.0) {
    AddPitchedRoof(builder, place, shell, overhang, thickness);
  } else {
    AddFlatRoof(builder, place, shell, overhang, thickness);
  }
}

void AddHall(MeshBuilder* builder, const QuarterPlan& plan, Random* random) {
  constexpr double kGateWidth = 4.0, kRamp = 1.5, kHigh = 3.0;
  Shell shell;
  shell.size = plan.hall_size;
  shell.bottom = kQuarterFoundation;
  shell.height = random->Uniform(4.8, 5.8);
  shell.gable = random->Chance(0.5) ? random->Uniform(1.6, 2.6) : 0.0;
  const double gate = plan.gate - 0.5 * kGateWidth;
  shell.openings[1] = {{gate - plan.hall_low.y(), kGateWidth, 0.0, 3.6}};
  // High windows: from the hall nobody sees the other street.
  shell.openings[3] = {{3.0, 2.0, kHigh, 1.0}, {8.0, 2.0, kHigh, 1.0}};
  shell.openings[2] = {{2.0, 1.6, kHigh, 1.0}, {9.0, 1.6, kHigh, 1.0}};
  const Rigid3 place = Upright({plan.hall_low.x(), plan.hall_low.y(), plan.hall_floor}, 0.0);
  AddShell(builder, place, shell);
  AddRoof(builder, place, shell, random);
  AddBox(builder, place, {0.05, 0.05, kQuarterFoundation},
         {shell.size.x() - 0.05, shell.size.y() - 0.05, 0.0});
  const double door = plan.hall_low.x() + plan.hall_size.x();
  AddRamp(builder, Upright({door + kRamp, gate - 0.2, -0.02}, kHalfPi),
          {kGateWidth + 0.4, kRamp + 0.06}, plan.hall_floor + 0.02, -0.5);
}

void FurnishHall(MeshBuilder* builder, const QuarterPlan& plan, Layout* layout, Random* random) {
  const Vector2d margin(1.8, 1.8);
  for (int i = 0; i < 6; ++i) {
    const double radius = random->Uniform(0.6, 1.3), angle = random->Uniform(0.5, 1.0);
    const Vector2d half = radius * Vector2d(std::cos(angle), std::sin(angle));
    const double yaw = random->Uniform(-0.5, 0.5), height = random->Uniform(0.7, 2.4);
    const auto at = layout->Place(plan.hall_low + margin, plan.hall_low + plan.hall_size - margin,
                                  radius, random);
    if (!at) continue;
    AddBox(builder, Upright({at->x(), at->y(), plan.hall_floor}, yaw), {-half.x(), -half.y(), -0.2},
           {half.x(), half.y(), height});
  }
}

// Windows in two heights and a door on the first side.
std::vector<Opening> DrawFront(double length, double height, bool with_door, Random* random) {
  const double width = random->Uniform(1.0, 1.6), pitch = random->Uniform(2.6, 3.4);
  const bool upper_first = random->Chance(0.5);
  std::vector<Opening> openings;
  for (int i = 0; 0.9 + pitch * i + width < length - 0.9; ++i) {
    const bool upper = (i % 2 == 0) == upper_first && height > 5.2;
    openings.push_back({0.9 + pitch * i, width, upper ? 3.6 : 0.9, 1.3});
    if (with_door && i == 1) openings.back() = {0.9 + pitch, 1.2, 0.15, 2.2};
  }
  return openings;
}

struct BuildingLot {
  Vector2d low, high;
  int front;                           // the side with the door
  double lowest = 3.5, highest = 8.0;  // of the eaves, metres
};

void AddBuilding(MeshBuilder* builder, const Terrain& terrain, const BuildingLot& lot,
                 Random* random) {
  Shell shell;
  const Vector2d room = lot.high - lot.low;
  shell.size = {room.x() * random->Uniform(0.85, 1.0), room.y() * random->Uniform(0.85, 1.0)};
  shell.bottom = kQuarterFoundation;
  shell.height = random->Uniform(lot.lowest, lot.highest);
  shell.thickness = random->Uniform(0.25, 0.4);
  // The ridge runs along x of the shell, which is turned where the lot is deeper than wide.
  const bool turned = shell.size.y() > shell.size.x();
  if (turned) std::swap(shell.size.x(), shell.size.y());
  const double slope = random->Uniform(0.5, 0.9);
  if (random->Chance(0.6)) shell.gable = 0.5 * slope * shell.size.y();
  for (int side = 0; side < 4; ++side) {
    const bool door = side == (turned ? (lot.front + 3) % 4 : lot.front);
    shell.openings[side] = DrawFront(shell.size[side % 2], shell.height, door, random);
  }
  const Vector2d center = 0.5 * (lot.low + lot.high);
  const double yaw = random->Uniform(-0.05, 0.05) + (turned ? kHalfPi : 0.0);
  const Rigid3 middle(Eigen::Quaterniond::Identity(),
                      {-0.5 * shell.size.x(), -0.5 * shell.size.y(), 0.0});
  const double floor = terrain.MaxHeight(lot.low, lot.high) - random->Uniform(0.0, 0.3);
  const Rigid3 place = Upright({center.x(), center.y(), floor}, yaw) * middle;
  AddShell(builder, place, shell);
  AddRoof(builder, place, shell, random);
  if (shell.gable <= 0.0) return;
  // A chimney through the roof.
  const double x = shell.size.x() * random->Uniform(0.2, 0.8), y = 0.5 * shell.size.y() + 0.8;
  AddBox(builder, place, {x - 0.35, y - 0.35, shell.height},
         {x + 0.35, y + 0.35, shell.height + shell.gable + random->Uniform(0.6, 1.0)});
}

void AddBuildings(MeshBuilder* builder, const QuarterPlan& plan, Random* random) {
  const auto edge = [&] { return random->Uniform(-0.8, 0.8); };
  std::vector<BuildingLot> lots = {{{-7.0, -13.5}, {7.5, 0.0}, 0, 4.5, 8.0},
                                   {{-30.0, -12.0 + edge()}, {-20.0 + edge(), 3.0}, 1, 4.0, 8.0},
                                   {{-29.5, 8.0 + edge()}, {-20.5 + edge(), 24.0}, 1},
                                   {{20.0 + edge(), -12.0 + edge()}, {29.0, 1.0}, 3},
                                   {{20.5 + edge(), 5.5 + edge()}, {29.5, 22.0}, 3, 4.0, 8.0},
                                   {{-10.0 + edge(), -33.0}, {11.0 + edge(), -25.5 + edge()}, 2}};
  // One of the streets' houses may be missing.
  const int missing = random->Index(8);
  if (missing == 1 || missing == 3) lots.erase(lots.begin() + missing + 1);
  for (const BuildingLot& lot : lots) AddBuilding(builder, plan.terrain, lot, random);
}

// Closes the gap between the hall and the building to its south, for the streets to be apart.
void AddGardenWall(MeshBuilder* builder, const QuarterPlan& plan, Random* random) {
  const double height = random->Uniform(2.4, 3.2), x = random->Uniform(-2.0, 2.0);
  AddWall(builder, Upright({x, -2.5, 0.0}, kHalfPi),
          Wall{plan.hall_low.y() + 2.6, 0.25, kQuarterFoundation, height, {}});
}

// A van: a box, and a lower one for its bonnet.
void AddVan(MeshBuilder* builder, const Rigid3& place, Random* random) {
  const double half = random->Uniform(1.8, 2.3), height = random->Uniform(1.9, 2.5);
  AddBox(builder, place, {-half, -0.95, -0.5}, {half - 0.9, 0.95, height});
  AddBox(builder, place, {half - 1.0, -0.9, -0.5}, {half, 0.9, 1.1});
}

void AddStreet(MeshBuilder* builder, const Terrain& terrain, const Vector2d& low,
               const Vector2d& high, Layout* layout, Random* random) {
  const Rigid3 sunk(Eigen::Quaterniond::Identity(), {0.0, 0.0, -0.4});
  const auto scatter = [&](int count, double radius, const auto& add) {
    for (int i = 0; i < count; ++i) {
      const double yaw = random->Uniform(-0.15, 0.15) + kHalfPi * (1 + 2 * random->Index(2));
      const auto at = layout->Place(low, high, radius, random);
      if (at) add(OnGround(terrain, *at, yaw));
    }
  };
  scatter(3, 2.4, [&](const Rigid3& place) { AddVan(builder, place, random); });
  scatter(1, 1.6, [&](const Rigid3& place) {
    const double height = random->Uniform(2.4, 3.0);
    AddBox(builder, place, {-1.2, -1.0, -0.5}, {1.2, 1.0, height});
  });
  scatter(3, 0.2, [&](const Rigid3& place) {
    AddCylinder(builder, place * sunk, random->Uniform(0.06, 0.12), random->Uniform(4.0, 6.0));
  });
  scatter(2, 1.2, [&](const Rigid3& place) {
    const double trunk = random->Uniform(2.8, 3.8), crown = random->Uniform(0.8, 1.2);
    AddCylinder(builder, place * sunk, 0.15, trunk + 0.4);
    AddBush(builder, place * Vector3d(0.0, 0.0, trunk + 0.5 * crown), crown, random);
  });
}

}  // namespace

Scene BuildQuarter(Random* random) {
  const QuarterPlan plan = DrawQuarterPlan(random);
  Scene scene;
  scene.drives = DrawDrives(plan, random);
  scene.probe_height = 2.5;
  scene.area_low = {-30.0, -31.0};
  scene.area_high = {30.0, 27.0};
  MeshBuilder builder;
  AddTerrain(&builder, plan.terrain);
  AddHall(&builder, plan, random);
  AddBuildings(&builder, plan, random);
  AddGardenWall(&builder, plan, random);
  Layout west(scene.drives[0].path, 1.0), east(scene.drives[1].path, 1.0);
  AddStreet(&builder, plan.terrain, {-18.5, -22.0}, {-10.0, 26.0}, &west, random);
  AddStreet(&builder, plan.terrain, {10.0, -22.0}, {18.5, 26.0}, &east, random);
  AddStreet(&builder, plan.terrain, {-7.0, -22.5}, {8.0, -17.0}, &east, random);
  FurnishHall(&builder, plan, &east, random);
  scene.mesh = builder.mesh();
  return scene;
}

}  // namespace planegraph
