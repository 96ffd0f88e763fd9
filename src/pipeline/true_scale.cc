#include "pipeline/true_scale.h"

#include <nlohmann/json.hpp>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"

namespace planegraph {

double ReadTrueScale(const std::string& path) {
  const auto json = nlohmann::json::parse(ReadTextFile(path), nullptr, false);
  if (!json.is_object()) throw InputError::InFile(path, "is not a JSON object");
  const auto scale = json.find("scale");
  if (scale == json.end() || !scale->is_number() || !(scale->get<double>() > 0.0)) {
    throw InputError::InFile(path, "a map's reference needs a `scale` above zero");
  }
  return scale->get<double>();
}

}  // namespace planegraph
