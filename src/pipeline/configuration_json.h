#pragma once

#include <nlohmann/json.hpp>

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// `configuration` of report.json: what was in effect, defaults included.
nlohmann::json ConfigurationJson(const MapResult& result, const MapOptions& options);

}  // namespace planegraph
