// segmentation_vs_pcl: CPU time and plane-level F1 of our segmentation and of PCL's region growing
// (with its normals; 30 neighbours, smoothness 3 degrees) on simulated scans of known labels. A
// true and a found plane, each of at least 100 points, match where the intersection over union of
// their points is at least one half.
#include <pcl/features/normal_3d.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/region_growing.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "planegraph/segmentation/segmenter.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

constexpr int kLeastPoints = 100;
constexpr int kNeighbours = 30;
constexpr float kSmoothness = 3.0f * std::numbers::pi_v<float> / 180.0f;

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<int> SegmentByPcl(const Cloud& cloud) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr points(new pcl::PointCloud<pcl::PointXYZ>);
  for (const auto& p : cloud.points) points->emplace_back(p.x(), p.y(), p.z());
  pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setSearchMethod(tree);
  estimation.setInputCloud(points);
  estimation.setKSearch(kNeighbours);
  estimation.compute(*normals);
  pcl::RegionGrowing<pcl::PointXYZ, pcl::Normal> growing;
  growing.setMinClusterSize(kLeastPoints);
  growing.setSearchMethod(tree);
  growing.setNumberOfNeighbours(kNeighbours);
  growing.setInputCloud(points);
  growing.setInputNormals(normals);
  growing.setSmoothnessThreshold(kSmoothness);
  std::vector<pcl::PointIndices> clusters;
  growing.extract(clusters);
  std::vector<int> labels(cloud.size(), -1);
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    for (const int i : clusters[c].indices) labels[i] = static_cast<int>(c);
  }
  return labels;
}

std::map<int, int> LargeLabels(const std::vector<int>& labels) {
  std::map<int, int> counts;
  for (const int label : labels) {
    if (label >= 0) counts[label]++;
  }
  std::erase_if(counts, [](const auto& entry) { return entry.second < kLeastPoints; });
  return counts;
}

struct Score {
  int truth = 0, found = 0, matched = 0;
  double seconds = 0.0;

  void Add(const std::vector<int>& true_labels, const std::vector<int>& found_labels) {
    const auto true_planes = LargeLabels(true_labels), found_planes = LargeLabels(found_labels);
    std::map<std::pair<int, int>, int> common;
    for (std::size_t i = 0; i < true_labels.size(); ++i) {
      common[{true_labels[i], found_labels[i]}]++;
    }
    truth += static_cast<int>(true_planes.size());
    found += static_cast<int>(found_planes.size());
    for (const auto& [pair, count] : common) {
      const auto t = true_planes.find(pair.first), f = found_planes.find(pair.second);
      if (t == true_planes.end() || f == found_planes.end()) continue;
      matched += 2 * count >= t->second + f->second - count;
    }
  }
  double F1() const { return 2.0 * matched / std::max(1, truth + found); }
  void Print(const std::string& cloud, const char* name) const {
    std::printf("| %s | %s | %.3f | %d | %.2f | %.2f | %.2f |\n", cloud.c_str(), name, seconds,
                found, double(matched) / std::max(1, found), double(matched) / std::max(1, truth),
                F1());
  }
};

void Compare(SceneKind kind, std::uint64_t seed, Score* total_ours, Score* total_pcl) {
  SimulationOptions options;
  options.scene = kind;
  options.seed = seed;
  options.scans = 2;
  options.scanner.beams = 1081;
  options.scanner.sweeps = 275;
  options.drone_mode = DroneMode::kOff;
  const LabelledScan scan = Simulate(options).robots[0].scans[1];
  Score ours, pcl;
  constexpr int kRepeats = 5;
  Segmentation segmentation;
  const double start = CpuSeconds();
  for (int k = 0; k < kRepeats; ++k) segmentation = SegmentPlanes(scan.cloud);
  ours.seconds = (CpuSeconds() - start) / kRepeats;
  ours.Add(scan.labels, segmentation.labels);
  const double start_pcl = CpuSeconds();
  const std::vector<int> labels = SegmentByPcl(scan.cloud);
  pcl.seconds = CpuSeconds() - start_pcl;
  pcl.Add(scan.labels, labels);
  const std::string cloud = SceneName(kind) + ", seed " + std::to_string(seed) + ", " +
                            std::to_string(scan.cloud.size()) + " points";
  ours.Print(cloud, "ours");
  pcl.Print("", "PCL");
  for (const auto& [part, total] : {std::pair(ours, total_ours), std::pair(pcl, total_pcl)}) {
    total->truth += part.truth, total->found += part.found, total->matched += part.matched;
    total->seconds += part.seconds;
  }
}

}  // namespace
}  // namespace planegraph

int main() {
  using namespace planegraph;
  Score ours, pcl;
  std::puts(
      "| scan | by | CPU s | planes | precision | recall | F1 |\n|---|---|---|---|---|---|---|");
  for (const SceneKind kind : {SceneKind::kYard, SceneKind::kHall}) {
    for (std::uint64_t seed = 0; seed < 2; ++seed) Compare(kind, seed, &ours, &pcl);
  }
  ours.Print("together", "ours");
  pcl.Print("", "PCL");
  std::printf("\nRatio of CPU times: %.0f\n", pcl.seconds / ours.seconds);
  return 0;
}
