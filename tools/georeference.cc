// `planegraph georeference`: metric scale and pose of a photogrammetric model.
#include "planegraph/registration/georeference.h"

#include <gflags/gflags.h>
#include <glog/logging.h>

#include <cmath>
#include <cstdio>

#include "planegraph/base/error.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/plane_input.h"
#include "tools/pose_json.h"

DEFINE_string(origin, "", "of the east-north-up frame: lat,lon,alt (degrees, metres)");

namespace planegraph::tools {
namespace {

// Larger standard deviations stand for "nothing is known": metres, radians, log of the scale.
constexpr double kInfinite = 1e3;

GeodeticPosition ParseOrigin(const std::string& text) {
  const std::vector<double> n = ParseNumbers("origin", text);
  if (n.size() != 3) throw UsageError("--origin takes lat,lon,alt");
  const GeodeticPosition origin{n[0], n[1], n[2]};
  if (!IsOnEarth(origin)) throw UsageError("--origin is no place on earth");
  return origin;
}

GeoreferenceOptions GeoreferenceOptionsFromFlags() {
  GeoreferenceOptions options;
  if (!FLAGS_method.empty()) options.method = FLAGS_method;
  if (options.method != "robust" && options.method != "paper") {
    throw UsageError("--method must be robust or paper, not '" + options.method + "'");
  }
  if (!FLAGS_origin.empty()) options.origin = ParseOrigin(FLAGS_origin);
  options.seed = FLAGS_seed;
  return options;
}

nlohmann::json OriginToJson(const std::optional<GeodeticPosition>& origin) {
  if (!origin) return nullptr;
  return {{"lat", origin->latitude}, {"lon", origin->longitude}, {"alt", origin->altitude}};
}

nlohmann::json ToJson(const Georeference& result, const CameraModel& model) {
  nlohmann::json json = {{"status", result.status},
                         {"reason", result.reason},
                         {"inliers", result.inliers},
                         {"origin", OriginToJson(result.origin)},
                         {"cameras", model.cameras.size()},
                         {"positions", result.fixes.size()},
                         {"time_offset", result.time_offset},
                         {"world_from_map", nullptr},
                         {"covariance", nullptr},
                         {"sigma_scale", nullptr},
                         {"rms", nullptr}};
  if (!result.has_estimate) return json;
  json["world_from_map"] = SimilarityToJson(result.world_from_map);
  json["covariance"] = CovarianceToJson(result.covariance, kInfinite * kInfinite);
  if (result.sigma_scale <= kInfinite) json["sigma_scale"] = result.sigma_scale;
  json["rms"] = result.rms;
  json["sigma_horizontal"] = result.sigma_horizontal;
  json["sigma_vertical"] = result.sigma_vertical;
  json["correlation_inflation"] = result.correlation_inflation;
  return json;
}

void PrintSummary(const Georeference& result, const CameraModel& model) {
  std::printf("%s%s%s\n", result.status.c_str(), result.reason.empty() ? "" : ": ",
              result.reason.c_str());
  if (!result.has_estimate) return;
  std::printf("scale %.6f m per unit, sigma %.3f %%\n", result.world_from_map.scale,
              100.0 * result.sigma_scale);
  std::printf(
      "%zu of %zu cameras agree, rms %.3f m; noise of a position %.3f m horizontally, "
      "%.3f m vertically; correlation inflates the variance %.1f times\n",
      result.inliers.size(), model.cameras.size(), result.rms, result.sigma_horizontal,
      result.sigma_vertical, result.correlation_inflation);
  if (result.time_offset != 0.0) {
    std::printf("GPS time is camera time plus %.3f s\n", result.time_offset);
  }
}

CameraModel ReadCamerasWithWarnings() {
  CameraModel model = ReadCameras(FLAGS_cameras);
  if (model.ignored_models > 0) {
    LOG(WARNING) << FLAGS_cameras << ": " << model.ignored_models
                 << " further reconstructions are left out";
  }
  return model;
}

GpsTrack ReadGpsWithWarnings() {
  GpsTrack track = ReadGps(FLAGS_gps);
  if (track.skipped > 0) {
    LOG(WARNING) << FLAGS_gps << ": " << track.skipped
                 << " rows, sentences or images without a usable position passed over";
  }
  return track;
}

int RunGeoreference(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 0, 0);
  RequireFlag("cameras");
  RequireFlag("gps");
  const GeoreferenceOptions options = GeoreferenceOptionsFromFlags();
  const CameraModel model = ReadCamerasWithWarnings();
  const GpsTrack track = ReadGpsWithWarnings();
  std::optional<ImageTimes> times;
  if (!FLAGS_image_times.empty()) times = ReadImageTimes(FLAGS_image_times);
  if (!times && !track.by_image) {
    throw UsageError("--gps gives positions by time: --image_times is needed, too");
  }
  const Georeference result = ComputeGeoreference(model, track, times, options);
  if (WantsText()) PrintSummary(result, model);
  EmitResult(ToJson(result, model), true);
  if (result.status == "ok") return 0;
  throw NoResultError(result.status + ": " + result.reason);
}

}  // namespace

Command GeoreferenceCommand() {
  return {"georeference",
          "",
          "metric scale and pose of a photogrammetric model by GPS",
          {"output", "cameras", "gps", "image_times", "method", "origin"},
          RunGeoreference};
}

}  // namespace planegraph::tools
