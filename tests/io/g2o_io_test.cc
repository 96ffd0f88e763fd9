#include "planegraph/io/g2o_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>
#include <random>

#include "io/g2o_parser.h"
#include "io/test_files.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

const std::string kTwoVertices =
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 7 1 2 3 0 0 1 0\n";

std::string G2oErrorOf(const std::string& text) {
  return ErrorOf([&] { ParseG2o(text, "f.g2o"); });
}

std::string Numbers(int first, int last) {
  std::string text;
  for (int i = first; i <= last; ++i) text.append(" ").append(std::to_string(i));
  return text;
}

class G2oIo : public TestFolder {};

TEST_F(G2oIo, ReadsEveryTag) {
  const G2oGraph graph =
      ParseG2o("# comment\n" + kTwoVertices +
                   "VERTEX_SE2 9 1 2 0.5\r\nFIX 0\nFIX 7 9\nVERTEX_PLANE 1 0 0 1 2\n" +
                   "VERTEX_PLANE 2 0 0 1 2\nEDGE_SE3:QUAT 0 7 1 2 3 0 0 0 1" + Numbers(1, 21) +
                   " \nEDGE_SE2 9 9 1 2 3" + Numbers(1, 6),
               "f");
  ASSERT_EQ(graph.vertices3.size(), 2u);
  EXPECT_EQ(graph.vertices3[1].id, 7);
  EXPECT_EQ(graph.vertices3[1].pose.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(graph.vertices3[1].pose.rotation.z(), 1.0);
  EXPECT_EQ(graph.vertices2[0].pose.angle, 0.5);
  EXPECT_EQ(graph.fixed, (std::vector<long long>{0, 7, 9}));
  EXPECT_EQ(graph.unknown.at("VERTEX_PLANE"), 2u);
  // Rows of the upper triangle: 1..6, 7..11, 12..15, 16..18, 19 20, 21.
  const Matrix6d& information = graph.edges3[0].information;
  EXPECT_EQ(information(0, 5), 6);
  EXPECT_EQ(information(1, 1), 7);
  EXPECT_EQ(information(2, 3), 13);
  EXPECT_EQ(information(3, 2), 13);
  EXPECT_EQ(information(5, 5), 21);
  EXPECT_EQ(graph.edges2[0].information(1, 2), 5);
  EXPECT_EQ(graph.edges2[0].information(2, 2), 6);
}

TEST_F(G2oIo, ComesBackBitForBit) {
  std::mt19937 rng(6);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(rng); };
  G2oGraph graph;
  for (int i = 0; i < 20; ++i) {
    const Rigid3 pose(Eigen::Quaterniond(draw(), draw(), draw(), draw()).normalized(),
                      {draw(), draw(), draw()});
    graph.vertices3.push_back({3 * i, pose});
    graph.vertices2.push_back({1000 + i, {draw(), draw(), draw()}});
    const Matrix6d a = Matrix6d::NullaryExpr(draw);
    graph.edges3.push_back({0, 3 * i, pose, a + a.transpose()});
    const Eigen::Matrix3d b = Eigen::Matrix3d::NullaryExpr(draw);
    graph.edges2.push_back({1000, 1000 + i, {draw(), draw(), draw()}, b + b.transpose()});
    graph.priors3.push_back({3 * i, pose, a + a.transpose()});
    graph.priors2.push_back({1000 + i, {draw(), draw(), draw()}, b + b.transpose()});
  }
  graph.fixed = {0, 1000};
  WriteG2o(Path("a.g2o"), graph);
  const G2oGraph read = ReadG2o(Path("a.g2o"));
  ASSERT_EQ(read.edges3.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(read.vertices3[i].id, graph.vertices3[i].id);
    EXPECT_EQ(read.vertices3[i].pose.translation, graph.vertices3[i].pose.translation);
    EXPECT_TRUE(read.vertices3[i].pose.rotation.isApprox(graph.vertices3[i].pose.rotation, 1e-15));
    EXPECT_EQ(read.edges3[i].information, graph.edges3[i].information);
    EXPECT_EQ(read.edges3[i].to, graph.edges3[i].to);
    EXPECT_EQ(read.edges2[i].information, graph.edges2[i].information);
    EXPECT_EQ(read.vertices2[i].pose.angle, graph.vertices2[i].pose.angle);
    EXPECT_EQ(read.priors3[i].id, graph.priors3[i].id);
    EXPECT_EQ(read.priors3[i].measurement.translation, graph.priors3[i].measurement.translation);
    EXPECT_EQ(read.priors3[i].information, graph.priors3[i].information);
    EXPECT_EQ(read.priors2[i].measurement.x, graph.priors2[i].measurement.x);
    EXPECT_EQ(read.priors2[i].information, graph.priors2[i].information);
  }
  EXPECT_EQ(read.fixed, graph.fixed);
  EXPECT_TRUE(read.unknown.empty());
}

TEST_F(G2oIo, VerticesAreATrajectory) {
  const auto path = Write("a.g2o", kTwoVertices + "VERTEX_SE2 9 1 2 1.5707963267948966\n");
  const Trajectory t = ReadTrajectory(path);
  ASSERT_EQ(t.size(), 3u);
  EXPECT_FALSE(t.has_times);
  EXPECT_EQ(t.poses[1].translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(t.times[2], 9.0);
  EXPECT_LE((t.poses[2].rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            1e-15);
}

TEST_F(G2oIo, BadLinesAreNamed) {
  const struct {
    std::string text, expected;
  } cases[] = {
      {"", "holds no VERTEX"},
      {"VERTEX_PLANE 1 2\n", "holds no VERTEX"},
      {"hello\n", "f.g2o:1: is not a g2o line"},
      {kTwoVertices + "VERTEX_SE3:QUAT 8 0 0 0 0 0 0\n", "f.g2o:3: numbers are missing"},
      {kTwoVertices + "VERTEX_SE3:QUAT 8 0 0 0 0 0 0 0\n", "f.g2o:3: the quaternion"},
      {kTwoVertices + "VERTEX_SE3:QUAT 8 0 0 0 0 0 0 1 5\n", "f.g2o:3: has too many"},
      {kTwoVertices + "VERTEX_SE3:QUAT 7 0 0 0 0 0 0 1\n", "f.g2o:3: vertex 7 occurs twice"},
      {kTwoVertices + "VERTEX_SE3:QUAT 7.5 0 0 0 0 0 0 1\n", "f.g2o:3: an id"},
      {kTwoVertices + "VERTEX_SE3:QUAT 1e300 0 0 0 0 0 0 1\n", "f.g2o:3: an id"},
      {kTwoVertices + "VERTEX_SE2 8 nan 0 0\n", "f.g2o:3: holds what is no finite"},
      {kTwoVertices + "VERTEX_SE2 8 zero 0 0\n", "f.g2o:3: holds what is no finite"},
      {kTwoVertices + "EDGE_SE3:QUAT 0 7 0 0 0 0 0 0 1" + Numbers(1, 20) + "\n", "missing"},
      {kTwoVertices + "\nEDGE_SE3:QUAT 0 8 0 0 0 0 0 0 1" + Numbers(1, 21) + "\n",
       "f.g2o:4: no vertex has the id 8"},
      {kTwoVertices + "FIX\n", "f.g2o:3:"},
      {kTwoVertices + "EDGE_PRIOR_SE2 8 0 0 0" + Numbers(1, 6) + "\n",
       "f.g2o:3: no vertex has the id 8"},
      {kTwoVertices + "EDGE_SE3_PRIOR 0 0 0 0 0 0 0 0 1" + Numbers(1, 20) + "\n", "missing"},
      // An offset that is not the identity, before its prior or after it.
      {kTwoVertices + "PARAMS_SE3OFFSET 3 0 0 1 0 0 0 1\nEDGE_SE3_PRIOR 0 3 0 0 0 0 0 0 1" +
           Numbers(1, 21) + "\n",
       "f.g2o:4: its sensor offset"},
      {kTwoVertices + "EDGE_SE3_PRIOR 0 3 0 0 0 0 0 0 1" + Numbers(1, 21) +
           "\nPARAMS_SE3OFFSET 3 0 0 1 0 0 0 1\n",
       "f.g2o:3: its sensor offset"}};
  for (const auto& c : cases) EXPECT_THAT(G2oErrorOf(c.text), HasSubstr(c.expected)) << c.text;
  EXPECT_THROW(ReadG2o(Path("none.g2o")), InputError);
}

TEST_F(G2oIo, SharedGraphsHaveTheirKnownSizes) {
  const std::string base = std::string(PLANEGRAPH_SHARED_DATA) + "/posegraph/";
  if (!std::filesystem::exists(base)) GTEST_SKIP() << "no " << base;
  // Counts as published with SE-Sync.
  const G2oGraph sphere = ReadG2o(base + "se_sync/sphere2500.g2o");
  EXPECT_EQ(sphere.vertices3.size(), 2500u);
  EXPECT_EQ(sphere.edges3.size(), 4949u);
  const G2oGraph bicocca = ReadG2o(base + "bicocca/B25b_0.000.g2o");
  EXPECT_EQ(bicocca.vertices2.size(), 8358u);
  EXPECT_EQ(bicocca.edges2.size(), 8803u);
}

}  // namespace
}  // namespace planegraph
