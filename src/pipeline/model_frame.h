#pragma once

#include <optional>
#include <string>

#include "planegraph/pipeline/map_front_end.h"

namespace planegraph {

/// A warning where a drone map's cloud and its cameras are not in one frame, as a cloud in UTM
/// beside cameras in the frame of their model: most of the cloud then lies far from all points that
/// the cameras' model has. Nothing where the model has none. Throws InputError.
std::optional<std::string> ModelFrameWarning(const DroneMapSite& site, const MapRecord& map);

}  // namespace planegraph
