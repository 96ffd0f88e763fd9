// `planegraph segment`: the planes of one cloud.
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "planegraph/base/error.h"
#include "planegraph/cloud/units.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/segmentation/planes_json.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/plane_input.h"

DEFINE_string(labelled, "", "file for the cloud with the int property `plane` (-1: none)");
DEFINE_string(kind, "laser", "where the cloud comes from: laser or vision");

namespace planegraph::tools {
namespace {

std::string Summary(const Segmentation& result) {
  const auto labelled = std::count_if(result.labels.begin(), result.labels.end(),
                                      [](std::int32_t label) { return label >= 0; });
  const double share =
      100.0 * static_cast<double>(labelled) / std::max<double>(1.0, result.labels.size());
  char text[256];
  std::snprintf(text, sizeof(text),
                "%zu points, %zu planes with %.1f %% of the points, noise %.1f mm + %.2f mm/m, "
                "%.2f s\n",
                result.labels.size(), result.planes.planes.size(), share,
                1e3 * result.noise.constant, 1e3 * result.noise.per_metre, SecondsSinceStart());
  return text;
}

std::string WhyNoPlanes(const Cloud& cloud, const Segmentation& result) {
  if (cloud.points.empty()) return "the cloud has no points";
  if (result.planes.point_count == 0) return "no point is farther away than --min_range";
  return "no plane was found among " + std::to_string(result.planes.point_count) + " points" +
         (AreUnitsDoubtful(cloud) ? "; half of them are farther than 100 m: are the units metres?"
                                  : "");
}

int RunSegment(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 1, 1);
  RequireFlag("output");
  const CloudKind kind = ParseKind("kind", FLAGS_kind);
  const Cloud cloud = ReadInputCloud(arguments[0]);
  const Segmentation result = SegmentInput(cloud, kind, arguments[0]);
  const bool found = !result.planes.planes.empty();
  const std::string reason = found ? "" : WhyNoPlanes(cloud, result);
  const nlohmann::json stamp = {{"planegraph", VersionStamp()},
                                {"seconds", SecondsSinceStart()},
                                {"input", arguments[0]},
                                {"reason", reason}};
  WritePlanes(FLAGS_output, result.planes, stamp.dump());
  if (!FLAGS_labelled.empty()) WriteCloud(FLAGS_labelled, cloud, {{"plane", result.labels}});
  if (FLAGS_json) std::cout << FormatPlanes(result.planes, stamp.dump());
  if (WantsText()) std::cout << Summary(result);
  if (!found) throw NoResultError(arguments[0] + ": " + reason);
  return 0;
}

}  // namespace

Command SegmentCommand() {
  std::vector<std::string> flags = {"output", "labelled", "kind"};
  for (const auto& flag : SegmentationFlags()) flags.push_back(flag);
  return {"segment", "CLOUD --output=PLANES.json", "the planes of one cloud", flags, RunSegment};
}

}  // namespace planegraph::tools
