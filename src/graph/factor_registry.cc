#include "planegraph/graph/factor_registry.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "planegraph/base/error.h"

namespace planegraph {

const char* ToString(FactorKind kind) {
  switch (kind) {
    case FactorKind::kPlane:
      return "plane";
    case FactorKind::kMapPlane:
      return "map plane";
    case FactorKind::kPlanePair:
      return "plane pair";
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
    const auto known = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const auto& p) { return p.name == option && !p.is_field; });
    if (known == parameters.end()) {
      throw UsageError("factor '" + name + "' has no parameter '" + option + "'");
    }
    if (!std::isfinite(entry.second) || (known->is_positive && entry.second <= 0.0)) {
      throw UsageError("'" + option + "' of the factor '" + name + "' must be positive");
    }
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

const FactorType* FactorRegistry::MapPlaneFactorFor(const FactorType& plane_factor) const {
  if (plane_factor.map_counterpart == plane_factor.name) return nullptr;
  if (plane_factor.map_counterpart.empty()) {
    throw UsageError("the plane factor '" + plane_factor.name +
                     "' has no counterpart for drone maps");
  }
  return &Get(plane_factor.map_counterpart, FactorKind::kMapPlane);
}

FactorChoice FactorRegistry::Parse(const std::string& text, FactorKind kind) const {
  const std::size_t colon = text.find(':');
  FactorChoice choice{text.substr(0, colon), {}};
  const FactorType& type = Get(choice.name, kind);
  std::istringstream list(colon == std::string::npos ? "" : text.substr(colon + 1));
  for (std::string item; std::getline(list, item, ',');) {
    const std::size_t equals = item.find('=');
    std::istringstream value(equals == std::string::npos ? "" : item.substr(equals + 1));
    double number = 0.0;
    value >> number;
    if (value.fail() || !value.eof() || !std::isfinite(number)) {
      throw UsageError("'" + item + "' of the factor '" + choice.name + "' is not OPTION=NUMBER");
    }
    choice.options[item.substr(0, equals)] = number;
  }
  type.CheckOptions(choice.options);
  return choice;
}

}  // namespace planegraph
