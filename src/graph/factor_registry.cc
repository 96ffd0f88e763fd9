#include "planegraph/graph/factor_registry.h"

#include <algorithm>
#include <stdexcept>

#include "planegraph/base/error.h"

namespace planegraph {

const char* ToString(FactorKind kind) {
  switch (kind) {
    case FactorKind::kPlane:
      return "plane";
    case FactorKind::kMapPlane:
      return "map plane";
    case FactorKind::kPose:
      return "pose";
    case FactorKind::kMap:
      return "map";
  }
  return "";
}

double OptionOr(const FactorOptions& options, const std::string& name, double fallback) {
  const auto set = options.find(name);
  return set == options.end() ? fallback : set->second;
}

void FactorType::CheckOptions(const FactorOptions& options) const {
  for (const auto& entry : options) {
    const std::string& option = entry.first;
    const bool known =
        std::any_of(parameters.begin(), parameters.end(), [&](const FactorParameter& parameter) {
          return parameter.name == option && !parameter.is_field;
        });
    if (!known) throw UsageError("factor '" + name + "' has no parameter '" + option + "'");
  }
}

void FactorRegistry::Add(FactorType type) {
  const std::string name = type.name;
  if (!types_.emplace(name, std::move(type)).second) {
    throw std::invalid_argument("two factors are called '" + name + "'");
  }
}

const FactorType& FactorRegistry::Get(const std::string& name, FactorKind kind) const {
  const auto found = types_.find(name);
  if (found != types_.end() && found->second.kind == kind) return found->second;
  std::string names;
  for (const auto& [key, type] : types_) {
    if (type.kind == kind) names += (names.empty() ? "" : ", ") + key;
  }
  throw UsageError("unknown factor '" + name + "' (there are: " + names + ")");
}

const FactorType& FactorRegistry::MapPlaneFactorFor(const FactorType& plane_factor) const {
  for (const auto& [name, type] : types_) {
    const bool fits = type.plane_blocks == plane_factor.plane_blocks;
    if (type.kind == FactorKind::kMapPlane && fits) return type;
  }
  throw UsageError("the plane factor '" + plane_factor.name +
                   "' has no counterpart for drone maps");
}

}  // namespace planegraph
