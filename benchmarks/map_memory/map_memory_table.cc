// map_memory_table FOLDER MEGABYTES POINTS...: the table of docs/architecture.md. Peak memory and
// time of a drone map's front end, for clouds of copies of a simulated quarter side by side, each
// in a process of its own. The clouds are written to FOLDER and stay there.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "planegraph/base/atomic_file.h"
#include "planegraph/io/tile_file.h"
#include "planegraph/pipeline/map_front_end.h"
#include "planegraph/simulation/simulation.h"

namespace planegraph {
namespace {

// The quarter's cloud in metres, x east, y north, z up.
Cloud Quarter() {
  SimulationOptions options;
  options.scene = SceneKind::kQuarter;
  options.drone_mode = DroneMode::kOn;
  options.scans = 1;
  const SimulatedSite site = Simulate(options);
  Cloud cloud = site.drone->model.cloud;
  const Sim3& world_from_map = site.drone->model.world_from_map;
  for (auto& point : cloud.points) {
    point = (world_from_map * (point.cast<double>() + cloud.offset)).cast<float>();
  }
  for (auto& normal : cloud.normals) {
    normal = (world_from_map.rotation * normal.cast<double>()).cast<float>();
  }
  cloud.offset.setZero();
  return cloud;
}

void WriteCopy(const Cloud& cloud, const Eigen::Vector3f& shift, AtomicFile* file) {
  std::string bytes;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f point = cloud.points[i] + shift;
    bytes.append(reinterpret_cast<const char*>(point.data()), 12);
    bytes.append(reinterpret_cast<const char*>(cloud.normals[i].data()), 12);
    bytes.append(reinterpret_cast<const char*>(cloud.colors[i].data()), 3);
  }
  file->Write(bytes.data(), bytes.size());
}

// Copies in a square, row by row.
void WriteCopies(const Cloud& cloud, std::size_t points, const std::string& path) {
  Eigen::Vector3f low = cloud.points.front(), high = low;
  for (const auto& p : cloud.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const std::size_t copies = std::max<std::size_t>(1, (points + cloud.size() / 2) / cloud.size());
  const auto row = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(copies))));
  AtomicFile file(path);
  const std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                             std::to_string(copies * cloud.size()) +
                             "\nproperty float x\nproperty float y\nproperty float z\nproperty "
                             "float nx\nproperty float ny\nproperty float nz\nproperty uchar "
                             "red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  file.Write(header.data(), header.size());
  for (std::size_t k = 0; k < copies; ++k) {
    const auto column = static_cast<float>(k % row), line = static_cast<float>(k / row);
    WriteCopy(cloud, {column * (high - low).x(), line * (high - low).y(), 0.0f}, &file);
  }
  file.Commit();
}

void Prepare(const std::string& cloud, const MapMemory& memory) {
  Site site;
  site.maps.push_back({"map", cloud, "", "", "", {}, {}});
  std::vector<std::string> warnings;
  const MapRecord map = PrepareMap(site, 0, 2, &warnings, memory);
  ::rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const double patches = static_cast<double>(map.planes.patches.size() * sizeof(Patch)) / 1e6;
  std::printf("| %zu | %.0f | %s | %zu | %zu | %.0f | %.1f | %.1f | %.0f |\n", map.points,
              1e-6 * static_cast<double>(memory.bytes),
              map.tiles ? std::to_string(map.tiles->count()).c_str() : "in memory",
              map.planes.planes.size(), map.planes.patches.size(), patches, map.seconds_read,
              map.seconds_segment, 1024e-6 * static_cast<double>(usage.ru_maxrss));
  std::fflush(stdout);
}

// Runs the work in a process of its own, so that its memory is counted alone.
template <typename Work>
bool InProcess(const Work& work) {
  const ::pid_t child = ::fork();
  if (child == 0) {
    work();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return status == 0;
}

int Run(int count, char** arguments) {
  if (count < 4) {
    std::fprintf(stderr, "map_memory_table FOLDER MEGABYTES POINTS...\n");
    return 1;
  }
  const std::string folder = arguments[1];
  MapMemory memory;
  memory.bytes = static_cast<std::uint64_t>(1e6 * std::atof(arguments[2]));
  memory.scratch = folder;
  std::printf(
      "| points | `--map_memory` | tiles | planes | patches | their MB | read, s | segmented, s | "
      "peak "
      "memory, MB |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  std::fflush(stdout);
  for (int k = 3; k < count; ++k) {
    const std::string path = folder + "/" + arguments[k] + ".ply";
    const bool done =
        InProcess([&] {
          if (std::filesystem::exists(path)) return;
          WriteCopies(Quarter(), static_cast<std::size_t>(std::atof(arguments[k])), path);
        }) &&
        InProcess([&] { Prepare(path, memory); });
    if (!done) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace planegraph

int main(int count, char** arguments) { return planegraph::Run(count, arguments); }
