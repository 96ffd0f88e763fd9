#include "pipeline/map_output.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/map_colours.h"
#include "pipeline/tiled_thinning.h"
#include "planegraph/base/error.h"
#include "planegraph/base/parallel.h"
#include "planegraph/cloud/voxel_key.h"
#include "planegraph/evaluation/scan_merge.h"
#include "planegraph/io/cloud_writer.h"
#include "planegraph/io/tile_file.h"

namespace planegraph {
namespace {

// Colours without a camera, by plane, so that walls, floors and clutter can be told apart.
Rgb PlaneColour(int plane) {
  if (plane < 0) return {150, 150, 150};
  const double hue = std::fmod(0.618033988749895 * (plane + 1), 1.0) * 6.0;
  const auto channel = [hue](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    const double v = 0.85 - 0.55 * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0);
    return static_cast<std::uint8_t>(255.0 * v);
  };
  return {channel(5.0), channel(3.0), channel(1.0)};
}

// The same where it stands beside a camera's colours: pale, so that nobody takes it for one.
Rgb Subdued(const Rgb& colour) {
  Rgb pale;
  for (int c = 0; c < 3; ++c) pale[c] = static_cast<std::uint8_t>((colour[c] + 3 * 165) / 4);
  return pale;
}

// By plane + 1.
std::vector<Rgb> PlaneColours(const PlaneSet& set, bool subdued) {
  std::vector<Rgb> colours;
  for (int p = -1; p < static_cast<int>(set.planes.size()); ++p) {
    colours.push_back(subdued ? Subdued(PlaneColour(p)) : PlaneColour(p));
  }
  return colours;
}

struct MapPoint {
  Eigen::Vector3f position;
  Rgb colour;
  std::int32_t plane;
};

std::vector<std::uint32_t> Thinned(const Cloud& cloud, double voxel) {
  if (voxel > 0) return FirstOfEachVoxel(cloud, voxel);
  std::vector<std::uint32_t> all(cloud.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

// ---- the drone's part ----

// Robust scale of the heights of the laser's surfaces over the map's.
double MapSigma(const MapResult& result, std::size_t map) {
  std::vector<MapResidual> residuals;
  for (const MapPairRecord& pair : result.map_pairs) {
    if (!pair.used || pair.map != map) continue;
    residuals.insert(residuals.end(), pair.refinement.residuals.begin(),
                     pair.refinement.residuals.end());
  }
  return MeasureMapErrors(residuals).sigma;
}

bool IsJoined(const MapResult& result, std::size_t map) {
  return std::any_of(result.map_pairs.begin(), result.map_pairs.end(),
                     [&](const MapPairRecord& pair) { return pair.used && pair.map == map; });
}

// Stereo leaves single points anywhere: beyond this they are no part of a site, and no voxel.
Cloud WithoutStrays(Cloud cloud, double voxel, std::vector<std::int32_t>* labels) {
  constexpr double kFarthest = 1e4, kMostCells = 1e6;
  static_assert(kMostCells < kMostVoxels);
  const double farthest = voxel > 0 ? std::min(kFarthest, kMostCells * voxel) : kFarthest;
  std::vector<std::uint32_t> near;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    if (!(cloud.Position(i).cwiseAbs().maxCoeff() < farthest)) continue;
    (*labels)[near.size()] = (*labels)[i];
    near.push_back(i);
  }
  labels->resize(near.size());
  if (near.size() == cloud.size()) return cloud;
  return Select(cloud, near);
}

// Where a map's points go: to the world less an offset.
struct Placing {
  Placing(const MapResult& result, std::size_t map, const Eigen::Vector3d& offset_)
      : shifted_from_metric(result.solution.world_from_metric[map]), offset(offset_) {
    shifted_from_metric.translation -= offset;
    const auto& bent_maps = result.solution.bent_maps;
    if (map < bent_maps.size() && bent_maps[map].grid) bent = &bent_maps[map];
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& place) const {
    if (bent != nullptr) return *bent * place - offset;
    return shifted_from_metric * place;
  }

  Sim3 shifted_from_metric;
  const BentMap* bent = nullptr;
  Eigen::Vector3d offset;
};

void WriteDronePoints(const Cloud& cloud, const std::vector<std::int32_t>& labels,
                      const Placing& placing, const std::vector<std::uint32_t>& kept,
                      MapPlyWriter* writer) {
  for (const std::uint32_t i : kept) {
    const Rgb colour = cloud.colors.empty() ? Subdued(PlaneColour(labels[i])) : cloud.colors[i];
    writer->Add((placing * cloud.Position(i)).cast<float>(), colour, PointSource::kVision, -1,
                labels[i]);
  }
}

// As far as the scans that are registered to a map see.
SeenParts PartsSeen(const MapResult& result, std::size_t map) {
  SeenParts seen;
  const Sim3 metric_from_world = result.solution.world_from_metric[map].Inverse();
  for (const MapPairRecord& pair : result.map_pairs) {
    if (!pair.used || pair.map != map) continue;
    const auto& farthest = result.scans[pair.scan].planes.range_image.farthest();
    const float reach = farthest.empty() ? std::numeric_limits<float>::infinity()
                                         : *std::max_element(farthest.begin(), farthest.end());
    const Sim3 pose = metric_from_world * Sim3(result.solution.world_from_scan[pair.scan]);
    seen.Add(pose * result.scans[pair.scan].planes.viewpoint, pose.scale * reach);
  }
  return seen;
}

// The points of a map that does not fit in memory, tile by tile.
void WriteTiles(const TileFile& tiles, const Placing& placing, double voxel, MapColours* colours,
                MapPlyWriter* writer) {
  TiledThinning thinning(voxel, tiles.edge());
  for (std::size_t t = 0; t < tiles.count(); ++t) {
    std::vector<std::int32_t> labels = tiles.ReadLabels(t);
    const Cloud cloud = WithoutStrays(tiles.Load(t), voxel, &labels);
    const auto kept = thinning.Keep(cloud, Thinned(cloud, voxel));
    WriteDronePoints(cloud, labels, placing, kept, writer);
    colours->Add(cloud);
  }
}

// Writes one map and returns what its colours are for the laser's points.
MapColours WriteDroneMap(const MapResult& result, std::size_t map, const Eigen::Vector3d& offset,
                         double voxel, MapPlyWriter* writer) {
  constexpr double kLeastGate = 0.1, kWidestGate = 0.4;  // metres; walls are not much thicker
  const MapRecord& record = result.maps[map];
  const Placing placing(result, map, offset);
  const double gate = std::clamp(4 * MapSigma(result, map), kLeastGate, kWidestGate);
  if (record.tiles) {
    MapColours colours(record.planes, gate, PartsSeen(result, map));
    WriteTiles(*record.tiles, placing, voxel, &colours, writer);
    return colours;
  }
  MapColours colours(record.planes, gate);
  std::vector<std::int32_t> labels = record.labels;
  const DroneMapSite& source = result.site.maps[map];
  Cloud read = LoadMapCloud(source, record.metric_from_map);
  if (read.size() != labels.size()) {
    throw InputError::InFile(source.cloud, "has changed since it was read");
  }
  const Cloud cloud = WithoutStrays(std::move(read), voxel, &labels);
  WriteDronePoints(cloud, labels, placing, Thinned(cloud, voxel), writer);
  colours.Add(cloud);
  return colours;
}

std::vector<std::optional<MapColours>> WriteDroneMaps(const MapResult& result,
                                                      const Eigen::Vector3d& offset, double voxel,
                                                      MapPlyWriter* writer) {
  std::vector<std::optional<MapColours>> colours(result.maps.size());
  for (std::size_t m = 0; m < result.maps.size(); ++m) {
    if (IsJoined(result, m)) colours[m] = WriteDroneMap(result, m, offset, voxel, writer);
  }
  return colours;
}

// ---- the laser's part ----

// One map as a source of colours for one scan.
struct ColourSource {
  const MapColours* colours;
  Sim3 metric_from_scan;
  std::vector<Eigen::Vector3d> normals;  // of the scan's planes, metric axes
  const MapGrid* grid = nullptr;         // of a bent map
  std::vector<Sim3> tile_from_scan = {};

  Eigen::Vector3d PlaceOf(const Eigen::Vector3d& x_in_scan) const {
    const Eigen::Vector3d place = metric_from_scan * x_in_scan;
    return grid == nullptr ? place : tile_from_scan[grid->TileAt(place)] * x_in_scan;
  }

  void Bend(const BentMap& map, const Rigid3& world_from_scan) {
    grid = map.grid.get();
    for (std::size_t t = 0; grid != nullptr && t < map.world_from_tile.size(); ++t) {
      tile_from_scan.push_back(map.world_from_tile[t].Inverse() * Sim3(world_from_scan));
    }
  }

  std::optional<Rgb> Of(const Eigen::Vector3d& x_in_scan, std::int32_t plane) const {
    const Eigen::Vector3d point = PlaceOf(x_in_scan);
    return plane < 0 ? colours->At(point)
                     : colours->OnPlane(point, normals[static_cast<std::size_t>(plane)]);
  }
};

std::vector<ColourSource> SourcesOf(const MapResult& result, std::size_t scan,
                                    const std::vector<std::optional<MapColours>>& colours) {
  std::vector<ColourSource> sources;
  for (const MapPairRecord& pair : result.map_pairs) {
    if (!pair.used || pair.scan != scan || !colours[pair.map] || colours[pair.map]->empty()) {
      continue;
    }
    ColourSource source{&*colours[pair.map],
                        result.solution.world_from_metric[pair.map].Inverse() *
                            Sim3(result.solution.world_from_scan[scan]),
                        {}};
    for (const PlaneSegment& plane : result.scans[scan].planes.planes) {
      source.normals.push_back(source.metric_from_scan.rotation * plane.plane.normal);
    }
    if (pair.map < result.solution.bent_maps.size()) {
      source.Bend(result.solution.bent_maps[pair.map], result.solution.world_from_scan[scan]);
    }
    sources.push_back(std::move(source));
  }
  return sources;
}

Rgb ColourOf(const std::vector<ColourSource>& sources, const Eigen::Vector3d& x_in_scan,
             std::int32_t plane, const std::vector<Rgb>& plane_colours) {
  for (const ColourSource& source : sources) {
    if (const auto colour = source.Of(x_in_scan, plane)) return *colour;
  }
  return plane_colours[static_cast<std::size_t>(std::int64_t{plane} + 1)];
}

// One scan's share of the map: thinned in its own frame, moved to the world.
std::vector<MapPoint> MapPoints(const MapResult& result, std::size_t index,
                                const std::vector<std::optional<MapColours>>& colours,
                                const Eigen::Vector3d& offset, double voxel) {
  const ScanRecord& record = result.scans[index];
  const Cloud cloud = LoadScan(result.site.robots[record.robot], record.index).cloud;
  const auto sources = SourcesOf(result, index, colours);
  const bool subdued = std::any_of(colours.begin(), colours.end(),
                                   [](const auto& map) { return map && !map->empty(); });
  const std::vector<Rgb> plane_colours = PlaneColours(record.planes, subdued);
  const Rigid3& pose = result.solution.world_from_scan[index];
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  const Eigen::Vector3d shift = pose.translation - offset;
  const std::vector<std::uint32_t> kept = Thinned(cloud, voxel);
  std::vector<MapPoint> points;
  points.reserve(kept.size());
  for (const std::uint32_t i : kept) {
    const std::int32_t plane = i < record.labels.size() ? record.labels[i] : -1;
    const Eigen::Vector3d x_in_scan = cloud.Position(i);
    const Rgb colour =
        cloud.colors.empty() ? ColourOf(sources, x_in_scan, plane, plane_colours) : cloud.colors[i];
    points.push_back({(rotation * x_in_scan + shift).cast<float>(), colour, plane});
  }
  return points;
}

// A batch of scans at a time: as many as threads, whatever the size of the site.
void WriteScans(const MapResult& result, const OutputOptions& options,
                const std::vector<std::optional<MapColours>>& colours,
                const Eigen::Vector3d& offset, MapPlyWriter* writer) {
  const std::size_t batch = static_cast<std::size_t>(ResolveThreads(options.threads));
  for (std::size_t first = 0; first < result.scans.size(); first += batch) {
    const std::size_t count = std::min(batch, result.scans.size() - first);
    std::vector<std::vector<MapPoint>> parts(count);
    ParallelFor(count, options.threads, [&](std::size_t k) {
      parts[k] = MapPoints(result, first + k, colours, offset, options.map_voxel);
    });
    for (std::size_t k = 0; k < count; ++k) {
      for (const MapPoint& p : parts[k]) {
        writer->Add(p.position, p.colour, PointSource::kLaser, static_cast<std::int32_t>(first + k),
                    p.plane);
      }
    }
  }
}

}  // namespace

void WriteMapPly(const MapResult& result, const OutputOptions& options) {
  const Eigen::Vector3d offset =
      result.solution.world_from_scan.front().translation.array().round();
  MapPlyWriter writer(options.folder + "/map.ply", offset);
  const auto colours = WriteDroneMaps(result, offset, options.map_voxel, &writer);
  WriteScans(result, options, colours, offset, &writer);
  writer.Commit();
}

}  // namespace planegraph
