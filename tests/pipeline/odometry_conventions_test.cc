// Odometry that does not mean what its format says.
#include "pipeline/odometry_conventions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/small_site.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/file_conventions.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

// What Interpret undoes.
std::vector<Rigid3> Foreign(const FileConventions& conventions, std::vector<Rigid3> poses) {
  const Eigen::Matrix3d to_file = conventions.axes.transpose();
  for (Rigid3& pose : poses) {
    const Eigen::Matrix3d rotation =
        to_file * pose.rotation.toRotationMatrix() * to_file.transpose();
    pose = {Eigen::Quaterniond(rotation).normalized(),
            to_file * pose.translation / conventions.scale};
    if (conventions.body_from_world) pose = pose.Inverse();
    const Eigen::Quaterniond q = pose.rotation;
    if (conventions.w_first) pose.rotation = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());
  }
  return poses;
}

FileConventions Axes(const std::string& text) {
  FileConventions conventions;
  conventions.axes = ParseAxes(text);
  return conventions;
}

FileConventions WFirst() {
  FileConventions conventions;
  conventions.w_first = true;
  return conventions;
}

FileConventions Inverse() {
  FileConventions conventions;
  conventions.body_from_world = true;
  return conventions;
}

struct Way {
  std::string flags;
  FileConventions conventions;
};

std::vector<Way> Ways() {
  FileConventions camera_in_millimetres = Axes("z,-x,-y");
  camera_in_millimetres.scale = 0.001;
  return {{"convert --scale=0.001", {0.001}},
          {"convert --scale=0.01", {0.01}},
          {"convert --scale=0.3048", {0.3048}},
          {"convert --scale=1000", {1000.0}},
          {"convert --quaternions=wxyz", WFirst()},
          {"convert --inverse", Inverse()},
          {"convert --axes=z,-x,-y", Axes("z,-x,-y")},
          {"convert --axes=-z,-x,y", Axes("-z,-x,y")},
          {"convert --axes=z,-x,-y --scale=0.001", camera_in_millimetres}};
}

// A drive, its registrations and its odometry, each with noise of its own.
class Drive {
 public:
  Drive(std::uint64_t seed, std::size_t count) : random_(seed, 5) {
    Rigid3 pose;
    for (std::size_t i = 0; i < count; ++i) {
      truth.push_back(pose);
      const Rigid3 step{ExpSO3({Small(), Small(), random_.Uniform(-0.6, 0.6)}),
                        {random_.Uniform(0.8, 3.0), Small(), Small()}};
      pose = pose * step;
      if (i + 1 < count) Register(i, step);
      scans.emplace_back();
      scans.back().index = i;
      scans.back().reach = 20.0;
    }
    site.robots.emplace_back().name = "cart";
    SetOdometry(SimulateOdometry(truth, {}, &random_));
  }

  void SetOdometry(const std::vector<Rigid3>& poses) {
    Trajectory& odometry = site.robots[0].odometry.emplace();
    odometry.poses = poses;
    for (std::size_t i = 0; i < poses.size(); ++i) odometry.times.push_back(static_cast<double>(i));
  }
  const std::vector<Rigid3>& Odometry() const { return site.robots[0].odometry->poses; }

  void Register(std::size_t i, const Rigid3& step) {
    PairRecord& pair = chain.emplace_back();
    pair.target = i;
    pair.source = i + 1;
    pair.used = true;
    pair.registration.status = RegistrationStatus::kOk;
    pair.registration.refinement.target_from_source = step;
  }

  // A registration that found a wrong place.
  Rigid3 Anywhere() {
    const auto vector = [&](double most) {
      const double x = random_.Uniform(-most, most), y = random_.Uniform(-most, most);
      return Eigen::Vector3d(x, y, 0.1 * random_.Normal());
    };
    return {ExpSO3({0.0, 0.0, random_.Uniform(-3.1, 3.1)}), vector(5.0)};
  }
  void Misregister(std::size_t k) {
    chain[k].registration.refinement.target_from_source = Anywhere();
  }

  std::vector<std::string> Warnings() const {
    return OdometryConventionWarnings(site, scans, chain);
  }

  Site site;
  std::vector<ScanRecord> scans;
  std::vector<PairRecord> chain;
  std::vector<Rigid3> truth;

 private:
  double Small() { return 0.02 * random_.Normal(); }

  Random random_;
};

class AnyDrive : public testing::TestWithParam<std::uint64_t> {};

TEST_P(AnyDrive, ForeignOdometryIsNamed) {
  for (const Way& way : Ways()) {
    SCOPED_TRACE(way.flags);
    Drive drive(GetParam(), 9);
    drive.SetOdometry(Foreign(way.conventions, drive.Odometry()));
    const auto warnings = drive.Warnings();
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].ends_with(way.flags)) << warnings[0];
  }
}

// Whatever axes it is said to have, the odometry then agrees: a plane does not tell all apart.
TEST_P(AnyDrive, AnyAxesAreMended) {
  for (const char* text : {"y,z,x", "-y,x,z", "x,-y,z", "y,x,z", "-x,-y,z", "z,x,y", "x,-z,y"}) {
    SCOPED_TRACE(text);
    Drive drive(GetParam(), 9);
    drive.SetOdometry(Foreign(Axes(text), drive.Odometry()));
    const auto warnings = drive.Warnings();
    ASSERT_EQ(warnings.size(), 1u);
    const std::string flag = "--axes=";
    const std::string found = warnings[0].substr(warnings[0].rfind(flag) + flag.size());
    Drive mended = drive;
    mended.SetOdometry(Interpret(Axes(found), *drive.site.robots[0].odometry).poses);
    EXPECT_THAT(mended.Warnings(), testing::IsEmpty());
  }
}

TEST_P(AnyDrive, AThirdOfWrongRegistrationsHidesNothing) {
  for (const Way& way : Ways()) {
    SCOPED_TRACE(way.flags);
    Drive drive(GetParam(), 16);
    drive.SetOdometry(Foreign(way.conventions, drive.Odometry()));
    for (const std::size_t k : {1, 4, 7, 9, 12}) drive.Misregister(k);
    const auto warnings = drive.Warnings();
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(warnings[0].ends_with(way.flags)) << warnings[0];
  }
}

TEST_P(AnyDrive, GoodOdometryIsLeftAlone) {
  EXPECT_THAT(Drive(GetParam(), 9).Warnings(), testing::IsEmpty());
}

// No way to take it makes it right.
TEST_P(AnyDrive, WrongRegistrationsAreNotTheOdometrysFault) {
  Drive drive(GetParam(), 9);
  for (std::size_t k = 0; k < drive.chain.size(); ++k) drive.Misregister(k);
  EXPECT_THAT(drive.Warnings(), testing::IsEmpty());
}

// In a corridor scans may be taken for each other as if the robot had not moved: that is no scale.
TEST_P(AnyDrive, RegistrationsThatStandStillAreNoScale) {
  Drive drive(GetParam(), 9);
  for (PairRecord& pair : drive.chain) {
    pair.registration.refinement.target_from_source.translation *= 0.01;
  }
  EXPECT_THAT(drive.Warnings(), testing::IsEmpty());
}

TEST_P(AnyDrive, ARobotAtRestHasNoUnit) {
  Drive drive(GetParam(), 9);
  drive.SetOdometry(std::vector<Rigid3>(9));
  for (PairRecord& pair : drive.chain) pair.registration.refinement.target_from_source = {};
  EXPECT_THAT(drive.Warnings(), testing::IsEmpty());
}

// Two registrations prove nothing, but no scan reaches its neighbour.
TEST_P(AnyDrive, StepsLongerThanTheScansReachAreNamed) {
  Drive drive(GetParam(), 3);
  drive.SetOdometry(Foreign({0.001}, drive.Odometry()));
  const auto warnings = drive.Warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("between scans that reach 20 m: is its unit the metre?"));
}

INSTANTIATE_TEST_SUITE_P(Seeds, AnyDrive, testing::Range<std::uint64_t>(1, 21));

// ---- through the whole of `map` ----

class ForeignSite : public TestFolder, public testing::WithParamInterface<SceneKind> {
 protected:
  std::vector<std::string> Warnings(const SimulatedSite& site) {
    WriteSite(Path("site"), site);
    return MapScans(ReadSite(Path("site/site.yaml")), TwoThreads("none")).warnings;
  }
};

TEST_P(ForeignSite, IsNamedFromTheScansAlone) {
  const SimulatedSite ours = SmallSite(GetParam(), 8, 12);
  EXPECT_THAT(Warnings(ours), testing::IsEmpty());
  for (const Way& way : Ways()) {
    SCOPED_TRACE(way.flags);
    SimulatedSite foreign = ours;
    foreign.robots[0].odometry = Foreign(way.conventions, foreign.robots[0].odometry);
    EXPECT_THAT(Warnings(foreign), testing::ElementsAre(HasSubstr(way.flags)));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ForeignSite, testing::Values(SceneKind::kYard, SceneKind::kHall));

}  // namespace
}  // namespace planegraph
