#include "planegraph/io/gps_io.h"

#include <filesystem>

#include "io/file_bytes.h"
#include "io/gps_formats.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

GpsTrack ReadAnyGps(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return ReadExifFolder(path);
  const FileBytes file(path);
  return LooksLikeNmea(file.view()) ? ParseNmea(file.view()) : ParseGpsCsv(file.view(), path);
}

}  // namespace

GpsTrack ReadGps(const std::string& path) {
  GpsTrack track = ReadAnyGps(path);
  if (!track.fixes.empty()) return track;
  throw InputError::InFile(path, "holds no position (" + std::to_string(track.skipped) +
                                     " rows, sentences or images passed over)");
}

ImageTimes ReadImageTimes(const std::string& path) {
  const FileBytes file(path);
  ImageTimes times = ParseImageTimes(file.view(), path);
  if (times.times.empty()) throw InputError::InFile(path, "holds no image");
  return times;
}

}  // namespace planegraph
