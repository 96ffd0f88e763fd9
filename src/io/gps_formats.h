#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "planegraph/io/gps_io.h"

// The readers of one format each, from a file's whole content; `file` is its name for messages.
// They throw InputError. The track may be empty (ReadGps refuses that).

namespace planegraph {

GpsTrack ParseGpsCsv(std::string_view bytes, const std::string& file);
ImageTimes ParseImageTimes(std::string_view bytes, const std::string& file);

/// Sentences that are no good are counted, nothing is thrown.
GpsTrack ParseNmea(std::string_view bytes);
/// Whether one of the first lines holds a sentence.
bool LooksLikeNmea(std::string_view bytes);

/// The GPS position in the EXIF of a JPEG, if it has one that is complete and on earth.
std::optional<GeodeticPosition> ParseExifPosition(std::string_view bytes);
/// The images of a folder in name order.
GpsTrack ReadExifFolder(const std::string& folder);

}  // namespace planegraph
