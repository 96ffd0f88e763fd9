#include "registration/pair_sets.h"

#include <cstdio>
#include <fstream>

#include "planegraph/cloud/saturated_returns.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/segmentation/segmenter.h"

namespace planegraph {
namespace {

constexpr double kMinRange = 0.5;  // metres: the scanner's own carrier

PlaneSet Segment(const std::string& path) {
  const Cloud cloud = ReadCloud(path);
  std::vector<std::uint32_t> used;
  for (const std::uint32_t i : UnsaturatedReturns(cloud)) {
    if ((cloud.Position(i) - cloud.viewpoint).norm() >= kMinRange) used.push_back(i);
  }
  return SegmentPlanes(Select(cloud, used)).planes;
}

std::vector<PlaneSet> SegmentRun(const std::string& folder, int count, const char* ending) {
  std::vector<PlaneSet> planes;
  for (int k = 0; k < count; ++k) {
    char name[32];
    std::snprintf(name, sizeof(name), "/scan%03d.%s", k, ending);
    planes.push_back(Segment(folder + name));
  }
  return planes;
}

Rigid3 ReadMatrix(const std::string& path) {
  std::ifstream stream(path);
  Eigen::Matrix4d m;
  for (int k = 0; k < 16; ++k) stream >> m(k / 4, k % 4);
  return {Eigen::Quaterniond(ProjectToRotation(m.topLeftCorner<3, 3>())), m.topRightCorner<3, 1>()};
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> PairSet::Pairs() const {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t k = 0; k + 1 < planes.size(); ++k) pairs.emplace_back(k + 1, k);
  if (last_to_first) pairs.emplace_back(planes.size() - 1, 0);
  return pairs;
}

std::string PairSet::PairName(std::size_t source, std::size_t target) const {
  if (planes.size() == 2) return name;
  return name + " " + std::to_string(source) + " -> " + std::to_string(target);
}

std::vector<PairSet> ReadPairSets(const std::string& data) {
  const std::string kitti = data + "/pair_kitti/", site = data + "/hybrid-site-a/ugv/";
  const std::string hall = data + "/bedkowski_tls13", city = data + "/3dtk_dat";
  const auto poses = [](const std::string& path) { return ReadTrajectory(path).poses; };
  std::vector<PairSet> sets;
  sets.push_back({"pair_kitti",
                  {Segment(kitti + "target.ply"), Segment(kitti + "source.ply")},
                  {Rigid3(), ReadMatrix(kitti + "T_target_source.txt")},
                  0.05,
                  0.4});
  sets.push_back({"hybrid-site-a short", SegmentRun(site + "short", 7, "ply"),
                  poses(site + "short/truth.tum"), 0.03, 0.1});
  sets.push_back({"hybrid-site-a loop", SegmentRun(site + "loop", 24, "ply"),
                  poses(site + "loop/truth.tum"), 0.03, 0.1});
  sets.push_back({"bedkowski_tls13", SegmentRun(hall, 13, "pcd"),
                  poses(hall + "/reference_icp.tum"), 0.08, 0.5});
  sets.push_back({"3dtk_dat", SegmentRun(city, 3, "3d"),
                  poses(city + "/reference_slam6d_p2pl_full.tum"), 0.12, 2.5, true});
  return sets;
}

}  // namespace planegraph
