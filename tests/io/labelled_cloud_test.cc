#include "planegraph/io/labelled_cloud.h"

#include <gtest/gtest.h>

#include <limits>

#include "io/test_files.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/cloud_writer.h"

namespace planegraph {
namespace {

class Labelled : public TestFolder {};

TEST_F(Labelled, MapsReadBack) {
  MapPlyWriter writer(Path("map.ply"), {1e6, 2e6, 3.0});
  writer.Add({1, 2, 3}, {9, 8, 7}, PointSource::kVision, -1, 4);
  writer.Add({4, 5, 6}, {9, 8, 7}, PointSource::kLaser, 2, -1);
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  writer.Add({nothing, 5, 6}, {9, 8, 7}, PointSource::kLaser, 2, 1);
  writer.Commit();
  const auto map = ReadLabelledCloud(Path("map.ply"));
  ASSERT_TRUE(map);
  ASSERT_EQ(map->cloud.size(), 2u);
  EXPECT_EQ(map->cloud.Position(1), Eigen::Vector3d(1e6 + 4, 2e6 + 5, 9.0));
  EXPECT_EQ(map->planes, (std::vector<std::int32_t>{4, -1}));
  EXPECT_EQ(map->scans, (std::vector<std::int32_t>{-1, 2}));
  EXPECT_EQ(map->vision, (std::vector<std::uint8_t>{1, 0}));
}

TEST_F(Labelled, SegmentedCloudsReadBack) {
  Cloud cloud;
  cloud.points = {{1, 2, 3}, {4, 5, 6}};
  WriteCloud(Path("labelled.ply"), cloud, {{"plane", {7, -1}}});
  const auto labelled = ReadLabelledCloud(Path("labelled.ply"));
  ASSERT_TRUE(labelled);
  EXPECT_EQ(labelled->planes, (std::vector<std::int32_t>{7, -1}));
  EXPECT_EQ(labelled->scans, (std::vector<std::int32_t>{0, 0}));
}

TEST_F(Labelled, OtherFilesHaveNoLabels) {
  Cloud cloud;
  cloud.points = {{1, 2, 3}};
  WriteCloud(Path("plain.ply"), cloud);
  EXPECT_FALSE(ReadLabelledCloud(Path("plain.ply")));
  EXPECT_FALSE(ReadLabelledCloud(Write("text.xyz", "1 2 3\n")));
  EXPECT_THROW(ReadLabelledCloud(Path("missing.ply")), InputError);
}

TEST_F(Labelled, ACutFileIsAnError) {
  Cloud cloud;
  cloud.points = {{1, 2, 3}, {4, 5, 6}};
  WriteCloud(Path("labelled.ply"), cloud, {{"plane", {7, -1}}});
  const std::string bytes = ReadTextFile(Path("labelled.ply"));
  EXPECT_THROW(ReadLabelledCloud(Write("cut.ply", bytes.substr(0, bytes.size() - 3))), InputError);
}

}  // namespace
}  // namespace planegraph
