#include "planegraph/io/trajectory_io.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>
#include <random>

#include "io/test_files.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

Rigid3 RandomPose(std::mt19937* rng) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(*rng); };
  const Eigen::Quaterniond rotation(draw(), draw(), draw(), draw());
  return {rotation.normalized(), 30.0 * Eigen::Vector3d(draw(), draw(), draw())};
}

void ExpectNear(const Rigid3& a, const Rigid3& b, double tolerance) {
  EXPECT_LE((a.translation - b.translation).norm(), tolerance);
  EXPECT_LE(AngleBetween(a.rotation, b.rotation), tolerance);
}

class TrajectoryIo : public TestFolder {};

TEST_F(TrajectoryIo, ReadsTumWithCommentsAndEitherSeparator) {
  const auto path = Write("a.tum",
                          "# time x y z qx qy qz qw\n\n"
                          "1.5 1 2 3 0 0 0 2e0\n");
  EXPECT_THROW(ReadTrajectory(path), InputError);  // norm 2
  Write("a.tum", "# comment\n1.5 1 2 3 0 0 0 1.005\r\n2.5, 4,5,6, 0,0,1,0\n");
  const Trajectory t = ReadTrajectory(path);
  ASSERT_EQ(t.size(), 2u);
  EXPECT_TRUE(t.has_times);
  EXPECT_EQ(t.times[1], 2.5);
  EXPECT_EQ(t.poses[0].translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(t.poses[0].rotation.norm(), 1.0);
  // A half turn about z takes x to -x.
  EXPECT_NEAR((t.poses[1].rotation * Eigen::Vector3d::UnitX()).x(), -1.0, 1e-15);
}

TEST_F(TrajectoryIo, TumKeepsEveryDigit) {
  std::mt19937 rng(1);
  Trajectory written;
  for (int i = 0; i < 50; ++i) {
    written.times.push_back(1305031102.160407 + i / 3.0);
    written.poses.push_back(RandomPose(&rng));
  }
  WriteTum(Path("b.tum"), written);
  const Trajectory read = ReadTrajectory(Path("b.tum"));
  ASSERT_EQ(read.size(), 50u);
  EXPECT_EQ(read.times, written.times);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(read.poses[i].translation, written.poses[i].translation);
    ExpectNear(read.poses[i], written.poses[i], 1e-15);
  }
}

TEST_F(TrajectoryIo, KittiIsRowMajorAndComesBack) {
  const auto path = Write("k.txt", "0 -1 0 10 1 0 0 20 0 0 1 30\n");
  const Trajectory t = ReadTrajectory(path);
  ASSERT_EQ(t.size(), 1u);
  EXPECT_FALSE(t.has_times);
  EXPECT_EQ(t.poses[0].translation, Eigen::Vector3d(10, 20, 30));
  EXPECT_LE((t.poses[0].rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            1e-15);
  std::mt19937 rng(2);
  Trajectory written;
  for (int i = 0; i < 20; ++i) {
    written.times.push_back(i);
    written.poses.push_back(RandomPose(&rng));
  }
  WriteKitti(path, written);
  const Trajectory read = ReadTrajectory(path);
  ASSERT_EQ(read.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) ExpectNear(read.poses[i], written.poses[i], 1e-14);
}

TEST_F(TrajectoryIo, BadTrajectoriesNameTheLine) {
  const struct {
    const char *text, *place;
  } cases[] = {{"1 2 3\n", "1"},
               {"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n", "2"},
               {"0 0 0 0 0 0 0 1\n\n# x\n1 0 0 0 0 0 zero 1\n", "4"},
               {"0 0 0 0 0 0 nan 1\n", "1"},
               {"0 0 0 0 0 0 0 0\n", "1"},
               {"0 0 0 0 0.5 0.5 0.5 0.6\n", "1"},
               {"1 0 0 0 0 1 0 0 0 0 -1 0\n", "1"},  // a reflection
               {"2 0 0 0 0 2 0 0 0 0 2 0\n", "1"},   // scaled
               {"# only a comment\n", ""},
               {"", ""}};
  for (const auto& c : cases) {
    const auto path = Write("bad.txt", c.text);
    try {
      ReadTrajectory(path);
      ADD_FAILURE() << "accepted: " << c.text;
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), path);
      EXPECT_EQ(error.place(), c.place) << c.text;
    }
  }
  EXPECT_THROW(ReadTrajectory(Path("none.tum")), InputError);
}

// Position (x right 100 cm, y up 200 cm, z forward 300 cm) is 3 m forward, 1 m right, 2 m up.
TEST_F(TrajectoryIo, PoseIsLeftHandedCentimetres) {
  const Rigid3 pose = Read3dtkPose(Write("scan000.pose", "100 200 300\n0 0 0\n"));
  EXPECT_EQ(pose.translation, Eigen::Vector3d(3, -1, 2));
  ExpectNear(Rigid3(pose.rotation, Eigen::Vector3d::Zero()), Rigid3(), 1e-15);
  // Ry(90 deg) of 3DTK takes its z (forward) to its x (right): a turn by -90 deg about our z.
  const Rigid3 turned = Read3dtkPose(Write("scan001.pose", "0 0 0\n0 90 0\n"));
  const Eigen::Vector3d forward = turned.rotation * Eigen::Vector3d::UnitX();
  EXPECT_LE((forward - Eigen::Vector3d(0, -1, 0)).norm(), 1e-15);
}

TEST_F(TrajectoryIo, FramesAreColumnMajorAndTheLastLineCounts) {
  const auto path = Write("scan000.frames",
                          "1 0 0 0 0 1 0 0 0 0 1 0 900 900 900 1 1\n"
                          "0 0 -1 0 0 1 0 0 1 0 0 0 100 200 300 1 2\n\n");
  const Rigid3 pose = Read3dtkFrames(path);
  EXPECT_EQ(pose.translation, Eigen::Vector3d(3, -1, 2));
  // The matrix is Ry(90 deg), see above.
  const Eigen::Vector3d forward = pose.rotation * Eigen::Vector3d::UnitX();
  EXPECT_LE((forward - Eigen::Vector3d(0, -1, 0)).norm(), 1e-15);
}

TEST_F(TrajectoryIo, FramesComeBack) {
  std::mt19937 rng(3);
  for (int i = 0; i < 100; ++i) {
    const Rigid3 pose = RandomPose(&rng);
    Write3dtkFrames(Path("scan000.frames"), pose);
    ExpectNear(Read3dtkFrames(Path("scan000.frames")), pose, 1e-12);
  }
}

TEST_F(TrajectoryIo, PosesComeBackAlsoAtTheGimbal) {
  std::mt19937 rng(4);
  for (int i = 0; i < 100; ++i) {
    const Rigid3 pose = RandomPose(&rng);
    Write3dtkPose(Path("scan000.pose"), pose);
    ExpectNear(Read3dtkPose(Path("scan000.pose")), pose, 1e-9);
  }
  for (const char* euler : {"0 90 0", "20 90 0", "0 -90 35", "10 -90 50", "0 180 0", "180 0 180"}) {
    const Rigid3 pose = Read3dtkPose(Write("gimbal.pose", std::string("1 2 3\n") + euler + "\n"));
    Write3dtkPose(Path("scan000.pose"), pose);
    ExpectNear(Read3dtkPose(Path("scan000.pose")), pose, 1e-7);
  }
}

TEST_F(TrajectoryIo, FolderPrefersFramesAndSortsThem) {
  Write("f/scan000.pose", "0 0 500\n0 0 0\n");
  Write("f/scan001.pose", "0 0 700\n0 0 0\n");
  EXPECT_EQ(ReadTrajectory(Path("f")).poses[1].translation, Eigen::Vector3d(7, 0, 0));
  Write3dtkFrames(Path("f/scan001.frames"), Rigid3({1, 0, 0, 0}, {2, 0, 0}));
  Write3dtkFrames(Path("f/scan000.frames"), Rigid3({1, 0, 0, 0}, {1, 0, 0}));
  const Trajectory t = ReadTrajectory(Path("f"));
  ASSERT_EQ(t.size(), 2u);
  EXPECT_FALSE(t.has_times);
  EXPECT_EQ(t.poses[0].translation.x(), 1.0);
  EXPECT_EQ(t.poses[1].translation.x(), 2.0);
  EXPECT_EQ(t.times[1], 1.0);
  std::filesystem::create_directory(Path("empty"));
  EXPECT_THROW(ReadTrajectory(Path("empty")), InputError);
}

TEST_F(TrajectoryIo, Bad3dtkPosesAreInputErrors) {
  EXPECT_THROW(Read3dtkFrames(Write("a.frames", "")), InputError);
  EXPECT_THROW(Read3dtkFrames(Write("a.frames", "1 2 3\n")), InputError);
  EXPECT_THROW(Read3dtkFrames(Write("a.frames", "9 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 2\n")),
               InputError);
  EXPECT_THROW(Read3dtkPose(Write("a.pose", "1 2 3\n")), InputError);
  EXPECT_THROW(Read3dtkPose(Write("a.pose", "1 2\n3 4 5\n")), InputError);
  EXPECT_THROW(Read3dtkPose(Write("a.pose", "1 2 3\n3 4 inf\n")), InputError);
}

// The same poses as 3DTK wrote them and as TUM with 9 digits.
TEST_F(TrajectoryIo, SharedFramesAgreeWithTheirTum) {
  const std::string base = std::string(PLANEGRAPH_SHARED_DATA) + "/3dtk_dat/reference_slam6d_";
  for (const std::string name : {"plain", "p2pl_full"}) {
    if (!std::filesystem::exists(base + name)) GTEST_SKIP() << "no " << base << name;
    const Trajectory frames = ReadTrajectory(base + name),
                     tum = ReadTrajectory(base + name + ".tum");
    ASSERT_EQ(frames.size(), 3u);
    ASSERT_EQ(tum.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) ExpectNear(frames.poses[i], tum.poses[i], 2e-6);
  }
}

}  // namespace
}  // namespace planegraph
