#include <array>
#include <unordered_set>

#include "io/csv_table.h"
#include "io/gps_formats.h"

namespace planegraph {
namespace {

using Names = std::vector<std::string>;

const Names& TimeNames() {
  static const Names names = {"time", "timestamp", "t", "seconds", "gps_time"};
  return names;
}
const Names& ImageNames() {
  static const Names names = {"image", "file",  "filename",   "file_name", "image_name",
                              "name",  "photo", "sourcefile", "label"};
  return names;
}
const std::array<Names, 3>& GeodeticNames() {
  static const std::array<Names, 3> names = {
      Names{"lat", "latitude", "gpslatitude", "gps_latitude"},
      Names{"lon", "lng", "long", "longitude", "gpslongitude", "gps_longitude"},
      Names{"alt", "altitude", "height", "ele", "elevation", "gpsaltitude", "gps_altitude"}};
  return names;
}
const std::array<Names, 3>& MetricNames() {
  static const std::array<Names, 3> names = {Names{"x", "east", "easting", "e"},
                                             Names{"y", "north", "northing", "n"},
                                             Names{"z", "up", "height", "alt", "altitude"}};
  return names;
}

// Which columns hold what.
struct Columns {
  std::size_t time = CsvTable::kNone, image = CsvTable::kNone;
  std::array<std::size_t, 3> position{};
  bool metric = false;
};

Columns FindColumns(const CsvTable& table) {
  Columns columns;
  columns.metric = table.Column(GeodeticNames()[0]) == CsvTable::kNone &&
                   table.Column(MetricNames()[0]) != CsvTable::kNone;
  const auto& names = columns.metric ? MetricNames() : GeodeticNames();
  for (std::size_t i = 0; i < 3; ++i) columns.position[i] = table.RequiredColumn(names[i]);
  columns.time = table.Column(TimeNames());
  columns.image = table.Column(ImageNames());
  if (columns.time == CsvTable::kNone && columns.image == CsvTable::kNone) {
    table.Fail("the first line names neither a column `time` nor a column `image`");
  }
  return columns;
}

bool LacksPosition(const CsvTable& table, const Columns& columns) {
  for (const std::size_t column : columns.position) {
    if (table.Field(column).empty()) return true;
  }
  return false;
}

GpsFix ParseRow(const CsvTable& table, const Columns& columns) {
  GpsFix fix;
  const auto number = [&](std::size_t i) { return table.Number(columns.position[i]); };
  const Eigen::Vector3d position(number(0), number(1), number(2));
  if (columns.metric) {
    fix.metric = position;
  } else {
    fix.geodetic = GeodeticPosition{position[0], position[1], position[2]};
    if (!IsOnEarth(*fix.geodetic)) table.Fail("the position is not on earth");
  }
  if (columns.image != CsvTable::kNone) {
    fix.image = std::string(table.Field(columns.image));
    if (fix.image.empty()) table.Fail("the name of the image is missing");
  }
  if (columns.time != CsvTable::kNone && !table.Field(columns.time).empty()) {
    fix.time = table.Number(columns.time);
  } else if (columns.image == CsvTable::kNone) {
    table.Fail("the time is missing");
  }
  return fix;
}

}  // namespace

GpsTrack ParseGpsCsv(std::string_view bytes, const std::string& file) {
  CsvTable table(bytes, file);
  const Columns columns = FindColumns(table);
  GpsTrack track;
  track.metric = columns.metric;
  track.by_image = columns.image != CsvTable::kNone;
  std::unordered_set<std::string> images;
  while (table.NextRow()) {
    if (LacksPosition(table, columns)) {
      ++track.skipped;
      continue;
    }
    track.fixes.push_back(ParseRow(table, columns));
    if (track.by_image && !images.insert(track.fixes.back().image).second) {
      table.Fail("the image " + track.fixes.back().image + " occurs twice");
    }
  }
  return track;
}

ImageTimes ParseImageTimes(std::string_view bytes, const std::string& file) {
  CsvTable table(bytes, file);
  const std::size_t time = table.RequiredColumn(TimeNames());
  std::size_t name = table.Column({"file"});
  if (name == CsvTable::kNone) name = table.RequiredColumn(ImageNames());
  ImageTimes times;
  times.source = file;
  while (table.NextRow()) {
    times.times.push_back(table.Number(time));
    times.files.emplace_back(table.Field(name));
  }
  return times;
}

}  // namespace planegraph
