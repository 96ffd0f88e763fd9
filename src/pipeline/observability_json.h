#pragma once

#include <nlohmann/json.hpp>

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// `observability` of report.json: what the planes of the whole graph leave open, one entry for all
/// scans that share a motion, with a sentence for people. Null where there was no graph.
nlohmann::json ObservabilityJson(const MapResult& result);

}  // namespace planegraph
