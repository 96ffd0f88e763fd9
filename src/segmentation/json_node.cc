#include "segmentation/json_node.h"

#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {

void JsonNode::Fail(const std::string& reason) const { throw InputError(file_, path_, reason); }

JsonNode JsonNode::Get(const std::string& key) const {
  if (!value_.is_object()) Fail("an object is expected");
  const auto found = value_.find(key);
  const std::string path = path_.empty() ? key : path_ + "." + key;
  if (found == value_.end()) throw InputError(file_, path, "is missing");
  return {*found, file_, path};
}

std::size_t JsonNode::Size() const {
  if (!value_.is_array()) Fail("an array is expected");
  return value_.size();
}

JsonNode JsonNode::At(std::size_t index) const {
  return {value_[index], file_, path_ + "[" + std::to_string(index) + "]"};
}

double JsonNode::Number(double least, double most) const {
  if (!value_.is_number()) Fail("a number is expected");
  const double number = value_.get<double>();
  if (!(number >= least && number <= most)) Fail("the number is out of range");
  return number;
}

std::int64_t JsonNode::Integer(std::int64_t least, std::int64_t most) const {
  if (!value_.is_number_integer()) Fail("an integer is expected");
  if (value_.is_number_unsigned() && value_.get<std::uint64_t>() > (std::uint64_t(1) << 62)) {
    Fail("the number is out of range");
  }
  const std::int64_t number = value_.get<std::int64_t>();
  if (number < least || number > most) Fail("the number is out of range");
  return number;
}

const std::string& JsonNode::String() const {
  if (!value_.is_string()) Fail("a string is expected");
  return value_.get_ref<const std::string&>();
}

Eigen::Vector3d JsonNode::Vector3(double most) const {
  if (Size() != 3) Fail("three numbers are expected");
  return {At(0).Number(-most, most), At(1).Number(-most, most), At(2).Number(-most, most)};
}

Eigen::Vector3d JsonNode::UnitVector3() const {
  const Eigen::Vector3d v = Vector3();
  if (!(std::abs(v.norm() - 1.0) <= 1e-6)) Fail("a unit vector is expected");
  return v;
}

}  // namespace planegraph
