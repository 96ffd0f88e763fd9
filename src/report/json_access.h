#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace planegraph {

// Reading a report of which any value may be missing, null or of another type than expected.

using Json = nlohmann::json;
using Keys = std::initializer_list<const char*>;

/// The value under the keys, one inside the other; null where one of them is missing.
const Json& Get(const Json& json, Keys keys);
/// A finite number; nothing where there is none.
std::optional<double> NumberAt(const Json& json, Keys keys);
/// Text; empty where there is none.
std::string TextAt(const Json& json, Keys keys);
/// True or false; nothing where there is neither.
std::optional<bool> FlagAt(const Json& json, Keys keys);
/// An array; an empty one where there is none.
const Json& ListAt(const Json& json, Keys keys);
/// Exactly `count` numbers; NaN stands for null. Nothing where there are none.
std::optional<std::vector<double>> NumbersAt(const Json& json, Keys keys, std::size_t count);
/// Three finite numbers.
std::optional<Eigen::Vector3d> VectorOf(const Json& list);
/// The same under the keys.
std::optional<Eigen::Vector3d> VectorAt(const Json& json, Keys keys);

}  // namespace planegraph
