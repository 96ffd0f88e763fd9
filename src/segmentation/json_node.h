#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace planegraph {

/// A value of a JSON document that knows its file and its path there, so that every complaint can
/// say where it belongs. All getters throw InputError.
class JsonNode {
 public:
  JsonNode(const nlohmann::json& value, std::string file, std::string path = "")
      : value_(value), file_(std::move(file)), path_(std::move(path)) {}

  /// The member `key` of an object.
  JsonNode Get(const std::string& key) const;
  bool Has(const std::string& key) const { return value_.is_object() && value_.contains(key); }
  /// The number of elements of an array.
  std::size_t Size() const;
  /// An element of an array.
  JsonNode At(std::size_t index) const;

  /// A finite number within [least, most].
  double Number(double least = -1e300, double most = 1e300) const;
  std::int64_t Integer(std::int64_t least, std::int64_t most) const;
  const std::string& String() const;
  /// Three finite numbers, of an absolute value of at most `most`.
  Eigen::Vector3d Vector3(double most = 1e300) const;
  Eigen::Vector3d UnitVector3() const;

  [[noreturn]] void Fail(const std::string& reason) const;

 private:
  const nlohmann::json& value_;
  std::string file_, path_;
};

}  // namespace planegraph
