#pragma once

#include <string>
#include <string_view>

#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// PLANES.json (docs/interface.md): the planes of one cloud with everything that registration
/// needs, so that registering from files gives what registering the clouds gives. Metres and
/// radians; numbers keep their full precision.

/// The text of the file. The members of the JSON object `stamp` come first (version, flags, ...).
std::string FormatPlanes(const PlaneSet& planes, const std::string& stamp = "{}");

/// Writes the file atomically. Throws InputError where that fails.
void WritePlanes(const std::string& path, const PlaneSet& planes, const std::string& stamp = "{}");

/// Reads the text of a PLANES.json; `name` stands for the file in errors. Throws InputError with
/// the JSON path of what is missing, of the wrong type, not finite, out of range, or not a unit
/// vector.
PlaneSet ParsePlanes(std::string_view text, const std::string& name);

/// Reads the file. Throws InputError.
PlaneSet ReadPlanes(const std::string& path);

}  // namespace planegraph
