// map.ply of a simulated yard that a robot and a drone saw.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>

#include "io/test_files.h"
#include "pipeline/map_colours.h"
#include "planegraph/cloud/kd_tree.h"
#include "planegraph/evaluation/scan_merge.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/cloud_writer.h"
#include "planegraph/io/tile_file.h"
#include "planegraph/pipeline/outputs.h"
#include "planegraph/segmentation/planes_json.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

struct Record {
  Eigen::Vector3d position;
  Rgb colour;
  int source;
  std::int32_t scan, plane;
};

// By the layout that docs/interface.md promises, not by the reader.
std::vector<Record> ReadRecords(const std::string& path, const Eigen::Vector3d& offset) {
  const std::string bytes = ReadTextFile(path), end = "end_header\n";
  std::vector<Record> records;
  for (std::size_t at = bytes.find(end) + end.size(); at + 24 <= bytes.size(); at += 24) {
    Eigen::Vector3f position;
    Record record;
    std::memcpy(position.data(), &bytes[at], 12);
    std::memcpy(record.colour.data(), &bytes[at + 12], 3);
    record.source = bytes[at + 15];
    std::memcpy(&record.scan, &bytes[at + 16], 4);
    std::memcpy(&record.plane, &bytes[at + 20], 4);
    record.position = offset + position.cast<double>();
    records.push_back(record);
  }
  return records;
}

// One run for all tests: they only look at it.
class HybridMap : public testing::Test {
 protected:
  static constexpr double kVoxel = 0.05;

  static void SetUpTestSuite() {
    folder_ = (std::filesystem::temp_directory_path() /
               ("planegraph_HybridMap_" + std::to_string(::getpid())))
                  .string();
    SimulationOptions options;
    options.seed = 1;
    options.scanner.beams = 361;
    options.scanner.sweeps = 120;
    simulated_ = Simulate(options);
    WriteSite(folder_ + "/site", *simulated_);
    MapOptions map;
    map.threads = 2;
    result_ = MapScans(ReadSite(folder_ + "/site/site.yaml"), map);
    WriteOutputs(*result_, {folder_ + "/two", kVoxel, 2});
    const Eigen::Vector3d offset = ReadCloud(folder_ + "/two/map.ply").offset;
    records_ = ReadRecords(folder_ + "/two/map.ply", offset);
  }
  static MapResult InTiles(int threads);
  static void TearDownTestSuite() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
    simulated_.reset();
    result_.reset();
    records_.clear();
  }

  static bool IsAnchored(std::size_t scan) {
    return std::any_of(result_->map_pairs.begin(), result_->map_pairs.end(),
                       [&](const auto& pair) { return pair.used && pair.scan == scan; });
  }
  // The truth's world from that of the run, which has GPS's errors.
  static Rigid3 TruthFromWorld() {
    return simulated_->robots[0].truth[0] * result_->solution.world_from_scan[0].Inverse();
  }
  static Cloud DroneCloud() {
    return LoadMapCloud(result_->site.maps[0],
                        result_->solution.world_from_metric[0] * result_->maps[0].metric_from_map);
  }

  static std::string folder_;
  static std::optional<SimulatedSite> simulated_;
  static std::optional<MapResult> result_;
  static std::vector<Record> records_;
};
std::string HybridMap::folder_;
std::optional<SimulatedSite> HybridMap::simulated_;
std::optional<MapResult> HybridMap::result_;
std::vector<Record> HybridMap::records_;

TEST_F(HybridMap, HoldsThePointsOfBothSources) {
  std::vector<std::size_t> scans(result_->scans.size(), 0), expected;
  std::size_t drone = 0;
  for (const Record& record : records_) {
    if (record.source == 1) {
      ++drone;
      EXPECT_EQ(record.scan, -1);
    } else {
      ASSERT_EQ(record.source, 0);
      ++scans.at(static_cast<std::size_t>(record.scan));
    }
  }
  for (const auto& scan : simulated_->robots[0].scans) {
    expected.push_back(FirstOfEachVoxel(RangeFilter(scan.cloud, 0.5, INFINITY), kVoxel).size());
  }
  EXPECT_EQ(scans, expected);
  const Cloud cloud = LoadMapCloud(result_->site.maps[0], result_->maps[0].metric_from_map);
  EXPECT_EQ(drone, FirstOfEachVoxel(cloud, kVoxel).size());
  EXPECT_GT(drone, cloud.size() / 2);
}

TEST_F(HybridMap, DronePointsLieWhereTheTruthHasThem) {
  const Cloud cloud = LoadMapCloud(result_->site.maps[0], result_->maps[0].metric_from_map);
  const auto kept = FirstOfEachVoxel(cloud, kVoxel);
  const Rigid3 truth_from_world = TruthFromWorld();
  std::vector<double> errors;
  std::size_t k = 0;
  for (const Record& record : records_) {
    if (record.source != 1) continue;
    const std::uint32_t i = kept.at(k++);
    ASSERT_EQ(record.plane, result_->maps[0].labels[i]);
    ASSERT_EQ(record.colour, simulated_->drone->model.cloud.colors[i]);
    const int plane = simulated_->drone->model.labels[i];
    if (plane < 0) continue;
    const Plane& truth = simulated_->planes[static_cast<std::size_t>(plane)];
    errors.push_back(std::abs(truth.SignedDistance(truth_from_world * record.position)));
  }
  ASSERT_GT(errors.size(), 10000u);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.08) << "metres; the drone's own noise, not GPS's metres";
}

TEST_F(HybridMap, LaserPointsTakeTheColoursOfTheMapWhereItCoversThem) {
  const Cloud drone = DroneCloud();
  const KdTree tree(drone.points);
  std::vector<KdTree::Neighbour> nearest;
  std::size_t covered = 0, alike = 0, far = 0;
  for (std::size_t k = 0; k < records_.size(); k += 7) {
    const Record& record = records_[k];
    if (record.source != 0) continue;
    tree.Nearest((record.position - drone.offset).cast<float>(), 1, &nearest);
    const auto& [least, most] = std::minmax_element(record.colour.begin(), record.colour.end());
    if (nearest[0].squared_distance > 1.0f) {
      ++far;
      ASSERT_TRUE(*least >= 123 && *most <= 179) << "a pale colour of its plane";
    }
    if (!IsAnchored(static_cast<std::size_t>(record.scan)) ||
        nearest[0].squared_distance > 0.05f * 0.05f || record.plane < 0) {
      continue;
    }
    ++covered;
    const Rgb& other = drone.colors[nearest[0].index];
    int difference = 0;
    for (int c = 0; c < 3; ++c) difference += std::abs(int(record.colour[c]) - int(other[c]));
    alike += difference < 3 * 30 ? 1 : 0;
  }
  EXPECT_GT(far, 1000u);
  ASSERT_GT(covered, 1000u);
  EXPECT_GT(static_cast<double>(alike), 0.8 * static_cast<double>(covered));
}

TEST_F(HybridMap, TheNumberOfThreadsChangesNoByte) {
  WriteOutputs(*result_, {folder_ + "/one", kVoxel, 1});
  EXPECT_TRUE(ReadTextFile(folder_ + "/one/map.ply") == ReadTextFile(folder_ + "/two/map.ply"));
}

// The voxels of the drone's frame that its points in map.ply are in.
std::set<std::array<long, 3>> DroneVoxels(const std::vector<Record>& records,
                                          const Sim3& world_from_metric, double voxel) {
  std::set<std::array<long, 3>> voxels;
  for (const Record& record : records) {
    if (record.source != 1) continue;
    // Floats of the file may end beside a voxel's border: cells twice as wide are compared.
    const Eigen::Vector3d p = world_from_metric.Inverse() * record.position / (2 * voxel);
    voxels.insert({std::lround(p.x()), std::lround(p.y()), std::lround(p.z())});
  }
  return voxels;
}

// The run with its drone map read in parts, from tiles on disk.
MapResult HybridMap::InTiles(int threads) {
  MapResult tiled = *result_;
  std::vector<std::string> warnings;
  MapMemory memory;
  memory.scratch = folder_;
  memory.bytes = 22000000;
  tiled.maps[0] = PrepareMap(result_->site, 0, threads, &warnings, memory);
  return tiled;
}

TEST_F(HybridMap, AMapInTilesOnDiskIsTheSame) {
  const MapResult tiled = InTiles(2);
  const MapRecord &whole = result_->maps[0], &parts = tiled.maps[0];
  ASSERT_FALSE(whole.tiles);
  ASSERT_TRUE(parts.tiles);
  EXPECT_GT(parts.tiles->count(), 4u);
  EXPECT_EQ(parts.tiles->edge(), MapSegmentationOptions::kTile);
  EXPECT_EQ(FormatPlanes(parts.planes), FormatPlanes(whole.planes)) << "to the byte";
  EXPECT_EQ(parts.points, whole.points);
  WriteOutputs(tiled, {folder_ + "/tiled", kVoxel, 2});
  const auto records =
      ReadRecords(folder_ + "/tiled/map.ply", ReadCloud(folder_ + "/tiled/map.ply").offset);
  ASSERT_EQ(records.size(), records_.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    ASSERT_EQ(records[i].source, records_[i].source);
    if (records[i].source == 0) {
      EXPECT_EQ(records[i].colour, records_[i].colour);
      EXPECT_EQ(records[i].position, records_[i].position);
    }
  }
  const Sim3& pose = result_->solution.world_from_metric[0];
  const auto found = DroneVoxels(records, pose, kVoxel), all = DroneVoxels(records_, pose, kVoxel);
  std::vector<std::array<long, 3>> other;
  std::set_symmetric_difference(found.begin(), found.end(), all.begin(), all.end(),
                                std::back_inserter(other));
  // Other points of the same voxels at the tiles' borders alone.
  EXPECT_LT(other.size(), 0.01 * static_cast<double>(all.size()));
}

TEST_F(HybridMap, AMapWithoutThinningKeepsAllPointsAndLabelsInTiles) {
  const MapResult tiled = InTiles(1);
  WriteOutputs(tiled, {folder_ + "/tiled0", 0.0, 1});
  WriteOutputs(*result_, {folder_ + "/whole0", 0.0, 1});
  std::vector<std::vector<std::string>> sorted;
  for (const char* name : {"/tiled0/map.ply", "/whole0/map.ply"}) {
    const std::string bytes = ReadTextFile(folder_ + name), end = "end_header\n";
    sorted.emplace_back();
    for (std::size_t at = bytes.find(end) + end.size(); at + 24 <= bytes.size(); at += 24) {
      if (bytes[at + 15] == 1) sorted.back().push_back(bytes.substr(at + 12, 12));
    }
    std::sort(sorted.back().begin(), sorted.back().end());
  }
  EXPECT_EQ(sorted[0], sorted[1]) << "colours and planes of the points";
}

// A point is in one patch of one tile, or in none.
TEST_F(HybridMap, TilesTooFullForTheMemoryAreCutSmaller) {
  std::vector<std::string> warnings;
  MapMemory memory;
  memory.scratch = folder_;
  std::size_t tiles = 0;
  for (const std::uint64_t bytes : {4000000, 1000000}) {
    memory.bytes = bytes;
    const MapRecord one = PrepareMap(result_->site, 0, 1, &warnings, memory);
    const MapRecord two = PrepareMap(result_->site, 0, 2, &warnings, memory);
    ASSERT_TRUE(one.tiles);
    EXPECT_LT(one.tiles->edge(), MapSegmentationOptions::kTile);
    EXPECT_GT(one.tiles->count(), tiles);
    tiles = one.tiles->count();
    EXPECT_EQ(FormatPlanes(one.planes), FormatPlanes(two.planes));
    EXPECT_EQ(one.tiles->Points(), result_->maps[0].points);
    double in_patches = 0.0, whole = 0.0, on_planes = 0.0;
    for (const Patch& patch : one.planes.patches) in_patches += patch.moments.count;
    for (const Patch& patch : result_->maps[0].planes.patches) whole += patch.moments.count;
    EXPECT_LE(in_patches, static_cast<double>(one.points));
    EXPECT_GT(in_patches, 0.95 * whole);
    for (const PlaneSegment& plane : one.planes.planes) on_planes += plane.moments.count;
    EXPECT_LE(on_planes, in_patches);
  }
}

TEST_F(HybridMap, AMapThatNoScanIsAnchoredToIsLeftOut) {
  MapResult apart = *result_;
  for (auto& pair : apart.map_pairs) pair.used = false;
  WriteOutputs(apart, {folder_ + "/apart", kVoxel, 2});
  const MergedMap map = ReadMapPly(folder_ + "/apart/map.ply");
  EXPECT_EQ(map.vision.size(), 0u);
  EXPECT_EQ(map.laser.size(), static_cast<std::size_t>(std::count_if(
                                  records_.begin(), records_.end(),
                                  [](const Record& record) { return record.source == 0; })));
}

// Its labels were those of other points.
TEST_F(HybridMap, AMapThatChangesDuringTheRunIsAnInputError) {
  const Cloud cloud = ReadCloud(result_->site.maps[0].cloud);
  for (const int change : {-1, 1}) {
    std::vector<std::uint32_t> points(cloud.size() - 1);
    std::iota(points.begin(), points.end(), 0u);
    if (change > 0) points.insert(points.end(), {0u, 1u});
    MapResult changed = *result_;
    changed.site.maps[0].cloud = folder_ + "/changed.ply";
    WriteCloud(folder_ + "/changed.ply", Select(cloud, points));
    EXPECT_THROW(WriteOutputs(changed, {folder_ + "/changed", kVoxel, 2}), InputError) << change;
  }
}

TEST_F(HybridMap, IsReadBackBySources) {
  const MergedMap map = ReadMapPly(folder_ + "/two/map.ply");
  const auto drone = static_cast<std::size_t>(std::count_if(
      records_.begin(), records_.end(), [](const Record& record) { return record.source == 1; }));
  EXPECT_EQ(map.vision.size(), drone);
  EXPECT_EQ(map.laser.size(), records_.size() - drone);
}

// ---- colours ----

// A level square of 2 m with its middle at the origin, red, seen from above.
Cloud RedRoof() {
  Cloud roof;
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) roof.points.push_back({0.1f * i, 0.1f * j, 0.0f});
  }
  roof.colors.assign(roof.size(), {200, 10, 20});
  return roof;
}

PlaneSet PatchesOfRoof() {
  PlaneSet planes;
  planes.kind = CloudKind::kVision;
  Patch patch;
  for (const auto& point : RedRoof().points) patch.moments.Add(point.cast<double>());
  patch.normal = Eigen::Vector3d::UnitZ();
  patch.size = 2.0;
  patch.sigma = 0.02;
  planes.patches.push_back(patch);
  return planes;
}

TEST(MapColours, ASurfaceThatFacesTheOtherWayHasNone) {
  MapColours colours(PatchesOfRoof(), 0.2);
  colours.Add(RedRoof());
  const Eigen::Vector3d above(0.3, 0.2, 0.1), below(0.3, 0.2, -0.1), high(0.3, 0.2, 0.4);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  ASSERT_TRUE(colours.OnPlane(above, up).has_value());
  EXPECT_EQ(*colours.OnPlane(above, up), (Rgb{200, 10, 20}));
  EXPECT_EQ(colours.OnPlane(below, up), colours.OnPlane(above, up)) << "an error, not a side";
  EXPECT_FALSE(colours.OnPlane(below, -up)) << "the underside";
  EXPECT_FALSE(colours.OnPlane(above, Eigen::Vector3d::UnitX())) << "a wall on the roof";
  EXPECT_FALSE(colours.OnPlane(high, up)) << "beyond the gate";
  EXPECT_FALSE(colours.OnPlane({5, 0, 0}, up)) << "beside the map";
}

TEST(VoxelColours, AreMeansOfTheirPoints) {
  Cloud cloud;
  cloud.points = {{0.1f, 0.1f, 0.1f}, {0.4f, 0.4f, 0.4f}, {-0.1f, 0.1f, 0.1f}, {1e30f, 0, 0}};
  cloud.colors = {{10, 20, 255}, {20, 21, 255}, {1, 2, 3}, {9, 9, 9}};
  const VoxelColours colours(cloud, 0.5);
  EXPECT_EQ(colours.voxels(), 2u) << "a point too far away is in none";
  EXPECT_EQ(*colours.At({0.2, 0.3, 0.0}), (Rgb{15, 21, 255}));
  EXPECT_EQ(*colours.At({-0.4, 0.3, 0.0}), (Rgb{1, 2, 3}));
  EXPECT_FALSE(colours.At({0.2, 0.3, 0.6}));
  EXPECT_FALSE(colours.At({1e30, 0, 0}));
  EXPECT_FALSE(colours.At({NAN, 0, 0}));
}

TEST(VoxelColours, GrowWithTheCloud) {
  Cloud cloud;
  for (int i = 0; i < 20000; ++i) {
    cloud.points.push_back({static_cast<float>(i % 100), static_cast<float>(i / 100), 0.5f});
    cloud.colors.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 256), 0});
  }
  const VoxelColours colours(cloud, 1.0);
  EXPECT_EQ(colours.voxels(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_EQ(colours.At(cloud.Position(i) + Eigen::Vector3d::Constant(0.3)), cloud.colors[i]);
  }
  cloud.colors.clear();
  EXPECT_TRUE(VoxelColours(cloud, 1.0).empty());
}

}  // namespace
}  // namespace planegraph
