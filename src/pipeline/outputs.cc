#include "planegraph/pipeline/outputs.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "pipeline/map_output.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/base/parallel.h"
#include "planegraph/io/g2o_io.h"
#include "planegraph/segmentation/planes_json.h"
#include "planegraph/solve/marginal_graph.h"

namespace planegraph {
namespace {

std::string ThreeDigits(std::size_t index) {
  char text[32];
  std::snprintf(text, sizeof(text), "%03zu", index);
  return text;
}

void WriteTrajectories(const MapResult& result, const std::string& folder) {
  for (std::size_t r = 0; r < result.site.robots.size(); ++r) {
    const std::string& robot = result.site.robots[r].name;
    CreateFolder(folder + "/frames/" + robot);
    Trajectory trajectory;
    for (const std::size_t i : ScansInFileOrder(result, r)) {
      trajectory.times.push_back(result.scans[i].time);
      trajectory.poses.push_back(result.solution.world_from_scan[i]);
      Write3dtkFrames(
          folder + "/frames/" + robot + "/scan" + ThreeDigits(result.scans[i].index) + ".frames",
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
    WritePlanes(folder + "/" + result.site.robots[scan.robot].name + "_" + ThreeDigits(scan.index) +
                    ".json",
                scan.planes);
  });
}

}  // namespace

void WriteOutputs(const MapResult& result, const OutputOptions& options) {
  CreateFolder(options.folder);
  WriteTrajectories(result, options.folder);
  WriteGraph(result, options.folder + "/graph.g2o");
  WritePlaneFiles(result, options);
  WriteMapPly(result, options);
}

}  // namespace planegraph
