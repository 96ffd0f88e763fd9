#include "report/json_access.h"

#include <cmath>
#include <limits>

namespace planegraph {

const Json& Get(const Json& json, Keys keys) {
  static const Json kNull;
  const Json* at = &json;
  for (const char* key : keys) {
    if (!at->is_object()) return kNull;
    const auto found = at->find(key);
    if (found == at->end()) return kNull;
    at = &*found;
  }
  return *at;
}

std::optional<double> NumberAt(const Json& json, Keys keys) {
  const Json& value = Get(json, keys);
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  if (!std::isfinite(number)) return std::nullopt;
  return number;
}

std::string TextAt(const Json& json, Keys keys) {
  const Json& value = Get(json, keys);
  return value.is_string() ? value.get<std::string>() : std::string();
}

std::optional<bool> FlagAt(const Json& json, Keys keys) {
  const Json& value = Get(json, keys);
  if (!value.is_boolean()) return std::nullopt;
  return value.get<bool>();
}

const Json& ListAt(const Json& json, Keys keys) {
  static const Json kEmpty = Json::array();
  const Json& value = Get(json, keys);
  return value.is_array() ? value : kEmpty;
}

std::optional<std::vector<double>> NumbersAt(const Json& json, Keys keys, std::size_t count) {
  const Json& list = ListAt(json, keys);
  if (list.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const Json& value : list) {
    if (!value.is_number() && !value.is_null()) return std::nullopt;
    numbers.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN()
                                      : value.get<double>());
  }
  return numbers;
}

std::optional<Eigen::Vector3d> VectorOf(const Json& list) {
  if (!list.is_array() || list.size() != 3) return std::nullopt;
  Eigen::Vector3d vector;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!list[axis].is_number()) return std::nullopt;
    vector[static_cast<Eigen::Index>(axis)] = list[axis].get<double>();
  }
  if (!vector.allFinite()) return std::nullopt;
  return vector;
}

std::optional<Eigen::Vector3d> VectorAt(const Json& json, Keys keys) {
  return VectorOf(Get(json, keys));
}

}  // namespace planegraph
