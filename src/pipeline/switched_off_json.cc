#include "pipeline/switched_off_json.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

Json ToJson(const SwitchedOff& off) {
  return {
      {"kind", off.kind},
      {"target", off.target},
      {"source", off.source.empty() ? Json(nullptr) : Json(off.source)},
      {"by", off.by},
      {"weight", off.weight},
      {"sigmas", off.sigmas},
      {"threshold_sigmas", off.threshold_sigmas > 0.0 ? Json(off.threshold_sigmas) : Json(nullptr)},
      {"contradicts", off.contradicts},
      {"reason", off.reason}};
}

}  // namespace

Json SwitchedOffJson(const MapResult& result) {
  Json list = Json::array();
  for (const SwitchedOff& off : result.refused) list.push_back(ToJson(off));
  for (const SwitchedOff& off : result.solution.switched_off) list.push_back(ToJson(off));
  return list;
}

}  // namespace planegraph
