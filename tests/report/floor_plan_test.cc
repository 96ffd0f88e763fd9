#include "report/floor_plan.h"

#include <gtest/gtest.h>

#include "report/sample_run.h"

namespace planegraph {
namespace {

// How strongly the plan shows a place of the world, 0 to 255.
int InkAt(const FloorPlan& plan, const PlanView& view, double x, double y) {
  const Eigen::Vector2d at = (view.OnPage({x, y}) - view.low) / PlanPixel(view);
  const std::size_t row = plan.image.height - 1 - static_cast<std::size_t>(at.y());
  return plan
      .palette[plan.image.pixels[row * plan.image.width + static_cast<std::size_t>(at.x())]][3];
}

class FloorPlanOfRoom : public testing::TestWithParam<double> {};

// A slope is what terrain is like; a floor has none.
TEST_P(FloorPlanOfRoom, WallsAreDarkFloorAndCeilingFaint) {
  const Cloud room = RoomCloud(GetParam());
  const PlanView view = ChooseView(room, {{5, 3, 1}});
  const FloorPlan plan = DrawFloorPlan(room, view);
  int walls = 0, floor = 0;
  for (int i = 0; i < 50; ++i) {
    const double x = 0.5 + 0.18 * i;
    walls += InkAt(plan, view, x, 0.0) > 180 || InkAt(plan, view, x, 0.07) > 180 ? 1 : 0;
    floor = std::max(floor, InkAt(plan, view, x, 3.0));
  }
  EXPECT_GE(walls, 45);
  EXPECT_LT(floor, 80);
  EXPECT_GT(InkAt(plan, view, 5.0, 3.0), 0);
  EXPECT_EQ(InkAt(plan, view, -0.4, 3.0), 0) << "nothing was seen outside";
}

INSTANTIATE_TEST_SUITE_P(Slopes, FloorPlanOfRoom, testing::Values(0.0, 0.05));

TEST(PlanView, ShowsMapAndScans) {
  const PlanView view = ChooseView(RoomCloud(), {{14, 3, 0}});
  EXPECT_FALSE(view.turned);
  EXPECT_LT(view.low.x(), 0.05);
  EXPECT_GT(view.high.x(), 14.0);
  EXPECT_LT(view.high.x(), 16.0);
}

TEST(PlanView, LaysALongYAxisAcrossThePage) {
  Cloud room = RoomCloud();
  for (auto& p : room.points) p = {p.y(), p.x(), p.z()};
  const PlanView view = ChooseView(room, {{3, 5, 1}});
  EXPECT_TRUE(view.turned);
  EXPECT_GT(view.Extent().x(), view.Extent().y());
  // x up and y to the left is a rotation: nothing is mirrored.
  const Eigen::Vector2d x = view.OnPage({1, 0}), y = view.OnPage({0, 1});
  EXPECT_EQ(x.x() * y.y() - x.y() * y.x(), 1.0);
}

TEST(PlanView, NorthPointsUpHoweverLongItIs) {
  Cloud street = RoomCloud();
  for (auto& point : street.points) point.y() *= 5.0F;
  EXPECT_TRUE(ChooseView(street, {{5, 3, 1}}).turned);
  const PlanView view = ChooseView(street, {{5, 3, 1}}, true);
  EXPECT_FALSE(view.turned);
  EXPECT_TRUE(view.north_up);
}

TEST(PlanView, StrayPointsDoNotShrinkTheMap) {
  Cloud room = RoomCloud();
  room.points.push_back({1000, 1000, 0});
  room.points.push_back({-300, 20, 0});
  const PlanView view = ChooseView(room, {{5, 3, 1}});
  EXPECT_LT(view.Extent().maxCoeff(), 15.0);
  EXPECT_LT(view.low.x(), 0.05);
  EXPECT_GT(view.high.x(), 9.95);
}

TEST(PlanView, NothingStillHasAnExtent) {
  const PlanView view = ChooseView({}, {});
  EXPECT_GT(view.Extent().minCoeff(), 0.0);
  const PlanView one = ChooseView({}, {{3e5, 5e6, 0}});
  EXPECT_TRUE(((one.low.array() < Eigen::Array2d(3e5, 5e6)) &&
               (one.high.array() > Eigen::Array2d(3e5, 5e6)))
                  .all());
}

TEST(FloorPlan, LargeCoordinatesKeepTheirDetail) {
  Cloud room = RoomCloud();
  room.offset = {356000, 5645000, 100};
  const PlanView view = ChooseView(room, {{356005, 5645003, 101}});
  EXPECT_LT(view.Extent().maxCoeff(), 12.0);
  EXPECT_EQ(DrawFloorPlan(room, view).image.pixels,
            DrawFloorPlan(RoomCloud(), ChooseView(RoomCloud(), {{5, 3, 1}})).image.pixels);
}

}  // namespace
}  // namespace planegraph
