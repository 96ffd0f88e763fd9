#pragma once

#include <nlohmann/json.hpp>

#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// An entry of `maps[]` of report.json.
nlohmann::json MapJson(const MapResult& result, std::size_t map);

}  // namespace planegraph
