#include "report/drone_photo.h"

#include <gtest/gtest.h>

namespace planegraph {
namespace {

PlanView TenMetres() {
  PlanView view;
  view.high = {10, 10};
  return view;
}

// Green ground of 8 x 8 m with its corner at (1, 1), and on it a red roof of 2 x 2 m at (6, 2).
Cloud GroundAndRoof() {
  Cloud cloud;
  for (int i = 0; i < 160; ++i) {
    for (int j = 0; j < 160; ++j) {
      const float x = 1.0f + 0.05f * static_cast<float>(i),
                  y = 1.0f + 0.05f * static_cast<float>(j);
      cloud.points.push_back({x, y, 0.0f});
      cloud.colors.push_back({30, 160, 40});
      if (x < 6 || x > 8 || y < 2 || y > 4) continue;
      cloud.points.push_back({x, y, 3.0f});
      cloud.colors.push_back({200, 20, 20});
    }
  }
  return cloud;
}

Rgba ColourAt(const DronePhoto& photo, const PlanView& view, double x, double y) {
  const Eigen::Vector2d at = (view.OnPage({x, y}) - view.low) / photo.pixel;
  const std::size_t row = photo.image.height - 1 - static_cast<std::size_t>(at.y());
  return photo.palette.at(
      photo.image.pixels.at(row * photo.image.width + static_cast<std::size_t>(at.x())));
}

TEST(DronePhoto, ShowsTheTopmostSurfaceInItsColour) {
  const PlanView view = TenMetres();
  const DronePhoto photo = DrawDronePhoto(GroundAndRoof(), view);
  ASSERT_LE(photo.palette.size(), 256u);
  const Rgba ground = ColourAt(photo, view, 3, 6), roof = ColourAt(photo, view, 7, 3);
  EXPECT_GT(ground[1], ground[0] + 40);
  EXPECT_GT(ground[1], ground[2] + 40);
  EXPECT_GT(roof[0], roof[1] + 60);
  EXPECT_EQ(ColourAt(photo, view, 0.5, 0.5)[3], 0) << "nothing was seen there";
  EXPECT_EQ(ground[3], 255);
}

TEST(DronePhoto, FillsSmallHolesAndLeavesLargeOnes) {
  Cloud cloud = GroundAndRoof();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto in = [&](double x, double y, double half) {
      return std::abs(cloud.points[i].x() - x) < half && std::abs(cloud.points[i].y() - y) < half;
    };
    if (in(3, 6, 0.04) || in(4, 4, 0.6)) cloud.points[i].x() = -50.0f;
  }
  const PlanView view = TenMetres();
  const DronePhoto photo = DrawDronePhoto(cloud, view);
  EXPECT_EQ(ColourAt(photo, view, 3, 6)[3], 255);
  EXPECT_EQ(ColourAt(photo, view, 4, 4)[3], 0);
}

TEST(DronePhoto, IsEmptyWithoutColoursOrPoints) {
  Cloud cloud = GroundAndRoof();
  EXPECT_TRUE(DrawDronePhoto({}, TenMetres()).palette.empty());
  PlanView elsewhere = TenMetres();
  elsewhere.low.array() += 100;
  elsewhere.high.array() += 100;
  EXPECT_TRUE(DrawDronePhoto(cloud, elsewhere).palette.empty());
  cloud.colors.clear();
  EXPECT_TRUE(DrawDronePhoto(cloud, TenMetres()).palette.empty());
}

TEST(DronePhoto, FollowsATurnedView) {
  PlanView turned;
  turned.turned = true;
  turned.low = {-10, 0};
  turned.high = {0, 10};
  const DronePhoto photo = DrawDronePhoto(GroundAndRoof(), turned);
  const Rgba roof = ColourAt(photo, turned, 7, 3), ground = ColourAt(photo, turned, 3, 7);
  EXPECT_GT(roof[0], roof[1]);
  EXPECT_GT(ground[1], ground[0]);
}

}  // namespace
}  // namespace planegraph
