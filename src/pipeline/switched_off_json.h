#pragma once

#include <nlohmann/json.hpp>

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// `switched_off[]` of report.json: what was refused before the joint solve, then what its loss
/// left without weight.
nlohmann::json SwitchedOffJson(const MapResult& result);

}  // namespace planegraph
