#include "pipeline/observability_json.h"

#include <cmath>
#include <cstdio>

#include "pipeline/json_values.h"
#include "planegraph/base/counted.h"
#include "planegraph/solve/covariance.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

std::string NameOf(const MapResult& result, int node) {
  const int scans = static_cast<int>(result.scans.size());
  if (node < scans) return result.scans[node].id;
  return result.maps[result.solution.graph.maps[node - scans].user_tag].id;
}

std::string SigmaText(MotionKind kind, double sigma) {
  double value = sigma;
  const char* unit = " m";
  if (kind == MotionKind::kRotation) value *= 180.0 / M_PI, unit = " deg";
  if (kind == MotionKind::kScale) value *= 100.0, unit = " %";
  char text[32];
  std::snprintf(text, sizeof(text), "%.2g", value);
  return text + std::string(unit);
}

std::string HoldText(const OpenMotion& motion) {
  if (!std::isfinite(motion.sigma)) return "nothing holds it";
  const std::string holder = motion.held_by == "gps" ? "GPS" : motion.held_by;
  return "sigma " + SigmaText(motion.kind, motion.sigma) +
         (holder.empty() ? "" : " from " + holder);
}

// "8 scans, each by itself", "3 scans as a whole against 5 others", "3 parts of 4, 2, 2 scans".
std::string PartsText(const OpenMotion& motion) {
  std::size_t count = 0;
  bool alone = true;
  std::string sizes;
  for (const auto& part : motion.parts) {
    count += part.size();
    alone &= part.size() == 1;
    sizes += (sizes.empty() ? "" : ", ") + std::to_string(part.size());
  }
  if (alone) return Counted(count, "scan") + ", each by itself";
  if (motion.parts.size() == 2) {
    return Counted(motion.parts[1].size(), "scan") +
           (motion.parts[1].size() > 1 ? " as a whole" : "") + " against " +
           Counted(motion.parts[0].size(), "other");
  }
  return Counted(motion.parts.size(), "part") + " of " + sizes + " scans";
}

// Scans that share no plane, for registrations may have been refused that found some.
std::string NothingJoins(const OpenMotion& motion) {
  const bool two = motion.parts.size() == 2 && motion.parts[0].size() > 1;
  const std::size_t smaller = motion.parts.back().size();
  if (!two) return "no registration joins " + PartsText(motion) + ": nothing holds them";
  return "no registration joins " + Counted(smaller, "scan") + " to " +
         Counted(motion.parts[0].size(), "other") +
         (smaller > 1 ? ": nothing holds them" : ": nothing holds it");
}

std::string Sentence(const MapResult& result, const OpenMotion& motion) {
  if (motion.kind == MotionKind::kEverything) {
    if (!std::isfinite(motion.sigma)) return NothingJoins(motion);
    return "no planes in common: " + PartsText(motion) + ", " + HoldText(motion);
  }
  if (motion.kind == MotionKind::kScale) {
    return "scale of " + NameOf(result, motion.node) + ": not observed by planes, " +
           HoldText(motion);
  }
  if (motion.parts.size() == 1) {
    return InWords(motion) +
           ": observed by planes from scan to scan, but not over the whole way, " +
           HoldText(motion);
  }
  return InWords(motion) + ": not observed by planes for " + PartsText(motion) + ", " +
         HoldText(motion);
}

Json MotionJson(const MapResult& result, const OpenMotion& motion) {
  Json json = {{"kind", Name(motion.kind)},
               {"directions", Json::array()},
               {"parts", Json::array()},
               {"degrees_of_freedom", motion.degrees_of_freedom},
               {"sigma_planes", Number(motion.sigma_planes)},
               {"sigma", Number(motion.sigma)},
               {"held_by", motion.held_by.empty() ? Json(nullptr) : Json(motion.held_by)},
               {"scan", NameOf(result, motion.node)},
               {"relative_to", NameOf(result, motion.reference)},
               {"text", Sentence(result, motion)}};
  for (const Eigen::Vector3d& axis : motion.axes) {
    json["directions"].push_back({axis.x(), axis.y(), axis.z()});
  }
  for (const auto& part : motion.parts) {
    Json names = Json::array();
    for (const int node : part) names.push_back(NameOf(result, node));
    json["parts"].push_back(std::move(names));
  }
  return json;
}

}  // namespace

Json ObservabilityJson(const MapResult& result) {
  if (!result.covariance) return nullptr;
  Json motions = Json::array();
  int open = 0;
  for (const OpenMotion& motion : result.covariance->OpenMotions()) {
    open += motion.degrees_of_freedom;
    motions.push_back(MotionJson(result, motion));
  }
  const CovarianceOptions& limits = result.covariance->options();
  return {{"motions", motions},
          {"open_degrees_of_freedom", open},
          {"thresholds",
           {{"translation", limits.translation_threshold},
            {"rotation", limits.rotation_threshold},
            {"scale", limits.scale_threshold}}}};
}

}  // namespace planegraph
