// Every figure that evo gives for three published trajectories.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "planegraph/evaluation/trajectory_error.h"

namespace planegraph {
namespace {

const std::string kFolder = std::string(PLANEGRAPH_SHARED_DATA) + "/trajectories/";

// "ate_rotation_sim3" -> {"ate", "rotation", "sim3"}.
std::vector<std::string> Split(const std::string& name) {
  std::vector<std::string> parts;
  std::stringstream stream(name);
  for (std::string part; std::getline(stream, part, '_');) parts.push_back(part);
  return parts;
}

PoseErrors AteOf(const PosePairs& pairs, const std::string& key) {
  return ComputeAte(pairs, ParsePoseAlignment(Split(key).back())).errors;
}

// Keys like rpe_rotation_10frames_all.
PoseErrors RpeOf(const PosePairs& pairs, const std::string& key) {
  const std::vector<std::string> parts = Split(key);
  RpeOptions options;
  options.delta = std::stod(parts[2]);
  options.unit =
      parts[2].find("frames") == std::string::npos ? DeltaUnit::kMetres : DeltaUnit::kFrames;
  options.all_pairs = parts[3] == "all";
  options.pairs_from_estimate = true;
  return ComputeRpe(pairs, options).errors;
}

void ExpectEqual(const Statistics& ours, const nlohmann::json& evo, double tolerance,
                 const std::string& what) {
  const std::pair<const char*, double> values[] = {{"rmse", ours.rmse},     {"mean", ours.mean},
                                                   {"median", ours.median}, {"std", ours.std},
                                                   {"min", ours.min},       {"max", ours.max}};
  for (const auto& [name, value] : values) {
    const double expected = evo.at(name);
    // An error of zero has no relative difference; below a micrometre the absolute one counts.
    EXPECT_NEAR(value, expected, tolerance * std::max(expected, 1e-6)) << what << " " << name;
  }
}

void CompareAll(const std::string& reference, const std::string& estimate, double tolerance) {
  const auto pairs =
      PairPoses(ReadTrajectory(kFolder + reference), ReadTrajectory(kFolder + estimate + ".txt"));
  const auto all = nlohmann::json::parse(std::ifstream(kFolder + "evo_expected.json"));
  int compared = 0;
  for (const auto& [key, evo] : all.at(estimate).items()) {
    if (key == "count") {
      EXPECT_EQ(pairs.reference.size(), evo.get<std::size_t>());
      continue;
    }
    const PoseErrors errors = key[0] == 'a' ? AteOf(pairs, key) : RpeOf(pairs, key);
    const bool rotation = key.find("rotation") != std::string::npos;
    ExpectEqual(rotation ? errors.rotation : errors.translation, evo, tolerance, key);
    EXPECT_EQ(errors.count, evo.value("count", errors.count)) << key;
    ++compared;
  }
  EXPECT_GE(compared, 14);
}

class Evo : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "the trajectories are not here";
  }
};

TEST_F(Evo, Tum) { CompareAll("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam", 1e-6); }

TEST_F(Evo, TumWithDrift) {
  CompareAll("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam_drift", 1e-6);
}

TEST_F(Evo, Kitti) { CompareAll("KITTI_00_gt.txt", "KITTI_00_ORB", 1e-5); }

}  // namespace
}  // namespace planegraph
