#include "planegraph/io/convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "io/test_files.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/g2o_io.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {
namespace {

class Convert : public TestFolder {
 protected:
  Convert() {
    Write("a.xyz", "1 2 3\n4 5 6\n");
    Write("a.tum", "0.5 1 2 3 0 0 0 1\n1.5 4 5 6 0 0 1 0\n");
  }
};

TEST_F(Convert, CloudsThroughEveryFormat) {
  std::string before = Path("a.xyz");
  for (const char* name : {"b.ply", "b.pcd", "b.3d", "b.txt", "c.ply"}) {
    const Conversion conversion = ConvertFile(before, Path(name));
    EXPECT_EQ(conversion.kind, "cloud") << name;
    EXPECT_EQ(conversion.count, 2u);
    before = Path(name);
  }
  const Cloud cloud = ReadCloud(before);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6));
}

TEST_F(Convert, TrajectoriesThroughEveryFormat) {
  std::string before = Path("a.tum");
  for (const char* name : {"b.txt", "b.g2o", "b.kitti", "folder/", "other", "x.frames", "c.tum"}) {
    const Conversion conversion = ConvertFile(before, Path(name));
    EXPECT_EQ(conversion.kind, "trajectory") << name;
    EXPECT_EQ(conversion.count, 2u);
    before = Path(name);
  }
  EXPECT_TRUE(std::filesystem::exists(Path("folder/scan001.frames")));
  const Trajectory t = ReadTrajectory(before);
  EXPECT_LE((t.poses[1].translation - Eigen::Vector3d(4, 5, 6)).norm(), 1e-12);
  EXPECT_NEAR(std::abs(t.poses[1].rotation.z()), 1.0, 1e-12);
  EXPECT_EQ(t.times[1], 1.0);  // formats without times were on the way
  EXPECT_EQ(ReadTrajectory(Path("b.txt")).times[1], 1.5);
}

TEST_F(Convert, GraphsKeepTheirEdges) {
  Write("a.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  EXPECT_EQ(ConvertFile(Path("a.g2o"), Path("b.g2o")).kind, "graph");
  EXPECT_EQ(ReadG2o(Path("b.g2o")).edges2.size(), 1u);
}

TEST_F(Convert, StampsAPoseGraph) {
  Write("a.g2o", "VERTEX_SE2 7 1 2 0\nVERTEX_SE2 3 4 5 0\n");
  Write("stamps.csv", "# seconds, whatever else\r\n1235603336.0099111, 8, x\r\n\n 1e9 ; 2");
  const Conversion conversion = ConvertFile(Path("a.g2o"), Path("b.tum"), {Path("stamps.csv")});
  EXPECT_EQ(conversion.kind, "trajectory");
  const Trajectory t = ReadTrajectory(Path("b.tum"));
  EXPECT_THAT(t.times, ::testing::ElementsAre(1235603336.0099111, 1e9));  // in the file's order
  EXPECT_EQ(t.poses[0].translation, Eigen::Vector3d(1, 2, 0));
  EXPECT_EQ(t.poses[1].translation, Eigen::Vector3d(4, 5, 0));
}

// A TUM file is a file of stamps itself: taken away by KITTI and given back nothing is lost.
TEST_F(Convert, StampsComeBack) {
  ConvertFile(Path("a.tum"), Path("b.kitti"));
  ConvertFile(Path("b.kitti"), Path("c.tum"), {Path("a.tum")});
  const Trajectory before = ReadTrajectory(Path("a.tum")), after = ReadTrajectory(Path("c.tum"));
  EXPECT_EQ(before.times, after.times);
  EXPECT_EQ(before.poses[1].translation, after.poses[1].translation);
}

TEST_F(Convert, WrongStampsAreSaid) {
  Write("a.g2o", "VERTEX_SE2 0 1 2 0\nVERTEX_SE2 1 4 5 0\n");
  Write("stamps.txt", "1.5\n2.5\n");
  const ConvertOptions stamps{Path("stamps.txt")};
  EXPECT_THROW(ConvertFile(Path("a.g2o"), Path("b.kitti"), stamps), UsageError);
  EXPECT_THROW(ConvertFile(Path("a.g2o"), Path("b.g2o"), stamps), UsageError);
  EXPECT_THROW(ConvertFile(Path("a.g2o"), Path("folder/"), stamps), UsageError);
  EXPECT_THROW(ConvertFile(Path("a.xyz"), Path("b.ply"), stamps), UsageError);
  EXPECT_THROW(ConvertFile(Path("a.tum"), Path("b.tum"), stamps), InputError);
  EXPECT_THROW(ConvertFile(Path("a.g2o"), Path("b.tum"), {Path("none.txt")}), InputError);
  for (const char* text :
       {"1.5\n", "1.5\n2.5\n3.5\n", "", "1.5\nnan\n", "time\n1.5\n", "1.5\n,2"}) {
    Write("stamps.txt", text);
    EXPECT_THROW(ConvertFile(Path("a.g2o"), Path("b.tum"), stamps), InputError) << text;
  }
  EXPECT_FALSE(std::filesystem::exists(Path("b.tum")));
}

// Poses that no convention leaves as they are.
Trajectory Winding() {
  Trajectory trajectory;
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d vector(0.2 * i, -0.3 + 0.1 * i, 0.5 * i);
    trajectory.times.push_back(i);
    trajectory.poses.push_back({ExpSO3(vector), {1.0 * i, 2.0 - i, 0.25 * i}});
  }
  return trajectory;
}

void ExpectSamePoses(const Trajectory& a, const Trajectory& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LE((a.poses[i].translation - b.poses[i].translation).norm(), 1e-12);
    EXPECT_LE(AngleBetween(a.poses[i].rotation, b.poses[i].rotation), 1e-7);
  }
}

class ForeignTrajectory : public Convert {
 protected:
  Trajectory Converted(const Trajectory& foreign, const FileConventions& conventions) {
    WriteTum(Path("foreign.tum"), foreign);
    ConvertFile(Path("foreign.tum"), Path("ours.tum"), {"", conventions});
    return ReadTrajectory(Path("ours.tum"));
  }
};

TEST_F(ForeignTrajectory, InMillimetres) {
  Trajectory foreign = Winding();
  for (Rigid3& pose : foreign.poses) pose.translation *= 1000.0;
  ExpectSamePoses(Converted(foreign, {0.001}), Winding());
}

TEST_F(ForeignTrajectory, WithWFirst) {
  Trajectory foreign = Winding();
  for (Rigid3& pose : foreign.poses) {
    const Eigen::Quaterniond q = pose.rotation;
    pose.rotation = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());  // x y z w of the file: w x y z
  }
  FileConventions conventions;
  conventions.w_first = true;
  ExpectSamePoses(Converted(foreign, conventions), Winding());
}

TEST_F(ForeignTrajectory, BodyFromWorld) {
  Trajectory foreign = Winding();
  for (Rigid3& pose : foreign.poses) pose = pose.Inverse();
  FileConventions conventions;
  conventions.body_from_world = true;
  ExpectSamePoses(Converted(foreign, conventions), Winding());
}

// A point of the body, seen from the world, is the same point in both conventions; a left-handed
// frame among them.
TEST_F(ForeignTrajectory, WithOtherAxes) {
  for (const char* text : {"z,-x,-y", "x,-y,-z", "-z,x,y", "x,-y,z"}) {
    SCOPED_TRACE(text);
    FileConventions conventions;
    conventions.axes = ParseAxes(text);
    EXPECT_EQ(AxesText(conventions.axes), text);
    const Eigen::Matrix3d to_foreign = conventions.axes.transpose();
    Trajectory foreign = Winding();
    for (Rigid3& pose : foreign.poses) {
      const Eigen::Vector3d zero = to_foreign * (pose * Eigen::Vector3d::Zero());
      Eigen::Matrix3d rotation;
      for (int axis = 0; axis < 3; ++axis) {
        rotation.col(axis) = to_foreign * (pose * conventions.axes.col(axis)) - zero;
      }
      pose = {Eigen::Quaterniond(rotation).normalized(), zero};
    }
    ExpectSamePoses(Converted(foreign, conventions), Winding());
  }
}

TEST_F(Convert, CloudsInOtherUnitsAndAxes) {
  ConvertFile(Path("a.xyz"), Path("b.ply"), {"", {0.01, ParseAxes("z,-x,-y")}});
  EXPECT_LE((ReadCloud(Path("b.ply")).points[1] - Eigen::Vector3f(0.06F, -0.04F, -0.05F)).norm(),
            1e-6F);
}

TEST_F(Convert, WrongConventionsAreUsageErrors) {
  for (const char* text : {"", "x", "x,y", "x,y,z,x", "x,x,z", "x,y,-", "x,y,w", "--x,y,z"}) {
    EXPECT_THROW(ParseAxes(text), UsageError) << text;
  }
  FileConventions w_first, inverse;
  w_first.w_first = true;
  inverse.body_from_world = true;
  Write("a.g2o", "VERTEX_SE2 0 1 2 0\n");
  EXPECT_THROW(ConvertFile(Path("a.xyz"), Path("b.ply"), {"", w_first}), UsageError);
  EXPECT_THROW(ConvertFile(Path("a.xyz"), Path("b.ply"), {"", inverse}), UsageError);
  EXPECT_THROW(ConvertFile(Path("a.g2o"), Path("b.tum"), {"", w_first}), UsageError);
  EXPECT_THROW(ConvertFile(Path("a.g2o"), Path("b.g2o"), {"", {0.1}}), UsageError);
}

TEST_F(Convert, WrongPairsAreInputErrors) {
  EXPECT_THROW(ConvertFile(Path("a.xyz"), Path("b.tum")), InputError);
  EXPECT_THROW(ConvertFile(Path("a.tum"), Path("b.ply")), InputError);
  EXPECT_THROW(ConvertFile(Path("a.xyz"), Path("b.docx")), InputError);
  EXPECT_THROW(ConvertFile(Path("none.xyz"), Path("b.ply")), InputError);
  EXPECT_THROW(ConvertFile(Path("none.txt"), Path("b.txt")), InputError);
  EXPECT_THROW(ConvertFile(Path("a.xyz"), ""), InputError);
  EXPECT_FALSE(std::filesystem::exists(Path("b.ply")));
}

}  // namespace
}  // namespace planegraph
