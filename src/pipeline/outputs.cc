#include "planegraph/pipeline/outputs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/parallel.h"
#include "planegraph/evaluation/scan_merge.h"
#include "planegraph/io/cloud_writer.h"
#include "planegraph/io/g2o_io.h"
#include "planegraph/segmentation/planes_json.h"
#include "planegraph/solve/marginal_graph.h"

namespace planegraph {
namespace {

std::string Number(std::size_t index) {
  char text[32];
  std::snprintf(text, sizeof(text), "%03zu", index);
  return text;
}

void WriteTrajectories(const MapResult& result, const std::string& folder) {
  for (std::size_t r = 0; r < result.site.robots.size(); ++r) {
    const std::string& robot = result.site.robots[r].name;
    CreateFolder(folder + "/frames/" + robot);
    Trajectory trajectory;
    for (std::size_t i = 0; i < result.scans.size(); ++i) {
      if (result.scans[i].robot != r) continue;
      trajectory.times.push_back(result.scans[i].time);
      trajectory.poses.push_back(result.solution.world_from_scan[i]);
      Write3dtkFrames(
          folder + "/frames/" + robot + "/scan" + Number(result.scans[i].index) + ".frames",
          trajectory.poses.back());
    }
    WriteTum(folder + "/trajectory_" + robot + ".tum", trajectory);
  }
}

// What a pair says of its relative pose where there is no joint graph to ask.
MarginalEdge EdgeOf(const PairRecord& pair) {
  return {static_cast<int>(pair.target), static_cast<int>(pair.source),
          pair.registration.target_from_source(), pair.registration.refinement.information};
}

std::vector<MarginalEdge> GraphEdges(const MapResult& result) {
  std::vector<MarginalEdge> edges;
  if (result.solution.graph.planes.empty()) {
    for (const auto& pair : result.pairs) {
      if (pair.used) edges.push_back(EdgeOf(pair));
    }
    return edges;
  }
  std::vector<std::pair<int, int>> pairs;
  for (const auto& pair : result.pairs) {
    if (pair.used) pairs.push_back({static_cast<int>(pair.target), static_cast<int>(pair.source)});
  }
  for (const auto& step : result.odometry) {
    const std::pair<int, int> p(static_cast<int>(step.target), static_cast<int>(step.source));
    if (std::find(pairs.begin(), pairs.end(), p) == pairs.end()) pairs.push_back(p);
  }
  edges = MarginalEdges(result.solution.graph, pairs);
  edges.insert(edges.end(), result.bridges.begin(), result.bridges.end());
  return edges;
}

void WriteGraph(const MapResult& result, const std::string& path) {
  G2oGraph graph;
  const auto& poses = result.solution.world_from_scan;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    graph.vertices3.push_back({static_cast<long long>(i), poses[i]});
    const bool first = i == 0 || result.component[i] != result.component[i - 1];
    const auto before = result.component.begin() + static_cast<std::ptrdiff_t>(i);
    if (first && std::find(result.component.begin(), before, result.component[i]) == before) {
      graph.fixed.push_back(static_cast<long long>(i));
    }
  }
  for (const auto& edge : GraphEdges(result)) {
    graph.edges3.push_back({edge.target, edge.source, edge.target_from_source,
                            G2oInformation(edge.target_from_source, edge.information)});
  }
  WriteG2o(path, graph);
}

void WritePlaneFiles(const MapResult& result, const OutputOptions& options) {
  const std::string folder = options.folder + "/planes";
  CreateFolder(folder);
  ParallelFor(result.scans.size(), options.threads, [&](std::size_t i) {
    const ScanRecord& scan = result.scans[i];
    WritePlanes(
        folder + "/" + result.site.robots[scan.robot].name + "_" + Number(scan.index) + ".json",
        scan.planes);
  });
}

// Colours without a camera: the laser's intensity where there is one, else by height of the normal
// and plane, so that walls, floors and clutter can be told apart.
using Colour = std::array<std::uint8_t, 3>;
Colour PlaneColour(int plane) {
  if (plane < 0) return {150, 150, 150};
  const double hue = std::fmod(0.618033988749895 * (plane + 1), 1.0) * 6.0;
  const auto channel = [hue](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    const double v = 0.85 - 0.55 * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0);
    return static_cast<std::uint8_t>(255.0 * v);
  };
  return {channel(5.0), channel(3.0), channel(1.0)};
}

// By plane + 1.
std::vector<Colour> PlaneColours(const PlaneSet& set) {
  std::vector<Colour> colours;
  for (int p = -1; p < static_cast<int>(set.planes.size()); ++p) colours.push_back(PlaneColour(p));
  return colours;
}

struct MapPoint {
  Eigen::Vector3f position;
  Colour colour;
  std::int32_t plane;
};

// One scan's share of the map: thinned in its own frame, moved to the world.
std::vector<MapPoint> MapPoints(const MapResult& result, std::size_t index,
                                const Eigen::Vector3d& offset, double voxel) {
  const ScanRecord& record = result.scans[index];
  const Cloud cloud = LoadScan(result.site.robots[record.robot], record.index).cloud;
  std::vector<std::uint32_t> kept;
  if (voxel > 0) {
    kept = FirstOfEachVoxel(cloud, voxel);
  } else {
    kept.resize(cloud.size());
    for (std::uint32_t i = 0; i < kept.size(); ++i) kept[i] = i;
  }
  const Rigid3& pose = result.solution.world_from_scan[index];
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  const Eigen::Vector3d shift = pose.translation - offset;
  const std::vector<Colour> plane_colours = PlaneColours(record.planes);
  std::vector<MapPoint> points;
  points.reserve(kept.size());
  for (const std::uint32_t i : kept) {
    const std::int32_t plane = i < record.labels.size() ? record.labels[i] : -1;
    const Colour& colour = cloud.colors.empty() ? plane_colours[plane + 1] : cloud.colors[i];
    points.push_back({(rotation * cloud.Position(i) + shift).cast<float>(), colour, plane});
  }
  return points;
}

void WriteMap(const MapResult& result, const OutputOptions& options) {
  const Eigen::Vector3d offset =
      result.solution.world_from_scan.front().translation.array().round();
  MapPlyWriter writer(options.folder + "/map.ply", offset);
  // A batch of scans at a time: as many as threads, whatever the size of the site.
  const std::size_t batch = static_cast<std::size_t>(ResolveThreads(options.threads));
  for (std::size_t first = 0; first < result.scans.size(); first += batch) {
    const std::size_t count = std::min(batch, result.scans.size() - first);
    std::vector<std::vector<MapPoint>> parts(count);
    ParallelFor(count, options.threads, [&](std::size_t k) {
      parts[k] = MapPoints(result, first + k, offset, options.map_voxel);
    });
    for (std::size_t k = 0; k < count; ++k) {
      for (const MapPoint& p : parts[k]) {
        writer.Add(p.position, p.colour, PointSource::kLaser, static_cast<std::int32_t>(first + k),
                   p.plane);
      }
    }
  }
  writer.Commit();
}

}  // namespace

void WriteOutputs(const MapResult& result, const OutputOptions& options) {
  CreateFolder(options.folder);
  WriteTrajectories(result, options.folder);
  WriteGraph(result, options.folder + "/graph.g2o");
  WritePlaneFiles(result, options);
  WriteMap(result, options);
}

}  // namespace planegraph
