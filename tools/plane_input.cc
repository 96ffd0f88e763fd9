#include "tools/plane_input.h"

#include <gflags/gflags.h>

#include <cmath>
#include <iostream>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "planegraph/base/error.h"
#include "planegraph/cloud/saturated_returns.h"
#include "planegraph/cloud/units.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/segmentation/map_segmenter.h"
#include "planegraph/segmentation/planes_json.h"
#include "tools/common_flags.h"

DEFINE_double(cell_size, 0.1, "edge of the finest octree cell, metres");
DEFINE_int32(min_points, 50, "least points of a plane");
DEFINE_double(min_area, 0.05, "least area of a plane, m^2");
DEFINE_string(noise, "",
              "noise of a point along the beam: CONSTANT[,PER_METRE], metres; empty: estimated");
DEFINE_string(area, "mask", "how areas are measured: mask or greedy_projection (Marton 2009)");

namespace planegraph::tools {
namespace {

void RequirePositive(const std::string& flag, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw UsageError("--" + flag + " must be greater than zero");
  }
}

NoiseModel ParseNoise(const std::string& text) {
  const std::vector<double> numbers = ParseNumbers("noise", text);
  if (numbers.size() > 2) throw UsageError("--noise takes CONSTANT[,PER_METRE]");
  NoiseModel noise{numbers[0], numbers.size() > 1 ? numbers[1] : 0.0};
  RequirePositive("noise", noise.constant);
  if (noise.per_metre < 0.0) throw UsageError("--noise must not be negative");
  return noise;
}

// A flag that the user has set goes before what the cloud's density asks for.
template <typename T, typename Flag>
void Override(const char* name, const Flag& flag, T* value) {
  if (!google::GetCommandLineFlagInfoOrDie(name).is_default) *value = flag;
}

SegmentationOptions VisionOptionsFromFlags(const Cloud& cloud) {
  SegmentationOptions options = VisionOptions(cloud);
  Override("cell_size", FLAGS_cell_size, &options.cell_size);
  Override("min_points", FLAGS_min_points, &options.min_points);
  Override("min_area", FLAGS_min_area, &options.min_area);
  return options;
}

SegmentationOptions SegmentationOptionsFromFlags(CloudKind kind, const Cloud& cloud) {
  RequirePositive("cell_size", FLAGS_cell_size);
  if (FLAGS_min_points < 3) throw UsageError("--min_points must be at least 3");
  if (!(FLAGS_min_area >= 0.0)) throw UsageError("--min_area must not be negative");
  if (FLAGS_area != "mask" && FLAGS_area != "greedy_projection") {
    throw UsageError("--area must be mask or greedy_projection, not '" + FLAGS_area + "'");
  }
  SegmentationOptions options;
  options.kind = kind;
  if (!FLAGS_noise.empty()) options.noise = ParseNoise(FLAGS_noise);
  if (kind == CloudKind::kVision) {
    const auto noise = options.noise;
    options = VisionOptionsFromFlags(cloud);
    options.noise = noise;
    options.greedy_projection_area = FLAGS_area == "greedy_projection";
    return options;
  }
  options.cell_size = FLAGS_cell_size;
  options.min_points = FLAGS_min_points;
  options.min_area = FLAGS_min_area;
  options.greedy_projection_area = FLAGS_area == "greedy_projection";
  return options;
}

std::vector<std::uint32_t> PointsToUse(const Cloud& cloud, CloudKind kind) {
  const Eigen::Vector3f sensor = (cloud.viewpoint - cloud.offset).cast<float>();
  const auto least = static_cast<float>(kind == CloudKind::kLaser ? FLAGS_min_range : 0.0);
  std::vector<std::uint32_t> indices;
  if (kind == CloudKind::kLaser) {
    indices = UnsaturatedReturns(cloud);
  } else {
    indices.resize(cloud.size());
    std::iota(indices.begin(), indices.end(), 0u);
  }
  std::erase_if(indices,
                [&](std::uint32_t i) { return (cloud.points[i] - sensor).norm() < least; });
  return indices;
}

void Scale(double scale, Cloud* cloud) {
  cloud->offset *= scale;
  cloud->viewpoint *= scale;
  for (auto& point : cloud->points) point *= static_cast<float>(scale);
}

}  // namespace

std::vector<std::string> SegmentationFlags() {
  return {"format", "min_range", "cell_size", "min_points", "min_area", "noise", "area"};
}

CloudKind ParseKind(const std::string& flag, const std::string& value) {
  if (value == "laser") return CloudKind::kLaser;
  if (value == "vision") return CloudKind::kVision;
  throw UsageError("--" + flag + " must be laser or vision, not '" + value + "'");
}

Cloud ReadInputCloud(const std::string& path) { return ReadCloud(path, FLAGS_format); }

Segmentation SegmentInput(const Cloud& cloud, CloudKind kind, const std::string& path) {
  const SegmentationOptions options = SegmentationOptionsFromFlags(kind, cloud);
  const std::vector<std::uint32_t> used = PointsToUse(cloud, kind);
  try {
    if (kind == CloudKind::kVision) return SegmentMap(cloud, {options, 25.6, FLAGS_threads});
    if (used.size() == cloud.size()) return SegmentPlanes(cloud, options);
    Segmentation result = SegmentPlanes(Select(cloud, used), options);
    std::vector<std::int32_t> labels(cloud.size(), -1);
    for (std::size_t i = 0; i < used.size(); ++i) labels[used[i]] = result.labels[i];
    result.labels = std::move(labels);
    return result;
  } catch (const std::length_error& error) {
    throw InputError::InFile(path, error.what());
  }
}

bool IsPlanesFile(const std::string& path) { return path.ends_with(".json"); }

PlaneSet LoadPlanes(const std::string& path, CloudKind kind, double scale) {
  if (IsPlanesFile(path)) return ReadPlanes(path);
  Cloud cloud = ReadInputCloud(path);
  if (scale != 1.0) Scale(scale, &cloud);
  if (kind == CloudKind::kLaser && AreUnitsDoubtful(cloud)) {
    std::cerr << "warning: " << path
              << ": half of the points are farther than 100 m: are the units metres?\n";
  }
  return SegmentInput(cloud, kind, path).planes;
}

// A scale that is only stated is taken to be good to two percent.
ScaleOfMap ParseMapScale(const std::string& text) {
  constexpr double kStatedSigma = 0.02;
  if (text.empty()) return {1.0, kStatedSigma};
  const std::size_t colon = text.find(':');
  const std::vector<double> scale = ParseNumbers("map_scale", text.substr(0, colon));
  if (scale.size() != 1 || !(scale[0] > 0.0)) {
    throw UsageError("--map_scale takes S or S:SIGMA, greater than zero");
  }
  if (colon == std::string::npos) return {scale[0], kStatedSigma};
  const std::vector<double> sigma = ParseNumbers("map_scale", text.substr(colon + 1));
  if (sigma.size() != 1 || !(sigma[0] > 0.0) || sigma[0] >= scale[0]) {
    throw UsageError("--map_scale=S:SIGMA: SIGMA is in metres per unit, between 0 and S");
  }
  return {scale[0], sigma[0] / scale[0]};
}

std::vector<double> ParseNumbers(const std::string& flag, const std::string& text) {
  std::vector<double> numbers;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    char* end = nullptr;
    numbers.push_back(std::strtod(part.c_str(), &end));
    if (part.empty() || *end != '\0' || !std::isfinite(numbers.back())) {
      throw UsageError("--" + flag + ": '" + part + "' is not a number");
    }
  }
  if (numbers.empty()) throw UsageError("--" + flag + " has no value");
  return numbers;
}

}  // namespace planegraph::tools
