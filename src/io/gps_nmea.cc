// NMEA 0183: positions from GGA, dates from RMC and ZDA, of any talker.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <set>

#include "io/gps_formats.h"
#include "io/text_scanner.h"

namespace planegraph {
namespace {

constexpr double kDay = 86400.0;

using Fields = std::vector<std::string_view>;

std::string_view FieldOf(const Fields& fields, std::size_t index) {
  return index < fields.size() ? fields[index] : std::string_view();
}

// A number of the sentence; NaN where the field is empty or no number.
double NumberOf(const Fields& fields, std::size_t index) {
  double value = 0.0;
  const bool number = ParseNumber(FieldOf(fields, index), &value);
  return number ? value : std::numeric_limits<double>::quiet_NaN();
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

// The fields of `$...*HH`, the checksum verified; empty where it is wrong or missing.
Fields VerifiedFields(std::string_view sentence) {
  const std::size_t star = sentence.find('*');
  if (star == sentence.npos || star + 3 > sentence.size()) return {};
  const int high = HexDigit(sentence[star + 1]), low = HexDigit(sentence[star + 2]);
  int sum = 0;
  for (const char c : sentence.substr(1, star - 1)) sum ^= static_cast<unsigned char>(c);
  if (high < 0 || low < 0 || sum != 16 * high + low) return {};
  return SplitFields(sentence.substr(1, star - 1), ',');
}

// hhmmss.ss as seconds of the day; NaN where it is none.
double SecondsOfDay(std::string_view text) {
  double value = 0.0;
  if (!ParseNumber(text, &value) || !(value >= 0.0 && value < 240000.0)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double hours = std::floor(value / 10000.0);
  const double minutes = std::floor((value - 10000.0 * hours) / 100.0);
  return 3600.0 * hours + 60.0 * minutes + (value - 10000.0 * hours - 100.0 * minutes);
}

// dddmm.mmmm and a letter as degrees; NaN where it is none.
double Degrees(const Fields& fields, std::size_t index, char positive, char negative) {
  const double value = NumberOf(fields, index);
  const std::string_view letter = FieldOf(fields, index + 1);
  if (letter.size() != 1 || (letter[0] != positive && letter[0] != negative) || !(value >= 0.0)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double degrees = std::floor(value / 100.0);
  const double angle = degrees + (value - 100.0 * degrees) / 60.0;
  return letter[0] == positive ? angle : -angle;
}

// Days since 1970; NaN where it is no date.
double DayNumber(double day, double month, double year) {
  const std::chrono::year_month_day date{
      std::chrono::year(static_cast<int>(std::clamp(year, 0.0, 9999.0))),
      std::chrono::month(static_cast<unsigned>(std::clamp(month, 0.0, 99.0))),
      std::chrono::day(static_cast<unsigned>(std::clamp(day, 0.0, 99.0)))};
  if (!date.ok()) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
}

// Height above the ellipsoid where the sentence has the geoid's, else above the sea.
std::optional<GeodeticPosition> PositionOfGga(const Fields& fields) {
  if (!(NumberOf(fields, 6) > 0.0)) return std::nullopt;  // no fix
  const double geoid = NumberOf(fields, 11);
  const GeodeticPosition position{Degrees(fields, 2, 'N', 'S'), Degrees(fields, 4, 'E', 'W'),
                                  NumberOf(fields, 9) + (std::isfinite(geoid) ? geoid : 0.0)};
  if (!IsOnEarth(position)) return std::nullopt;
  return position;
}

class NmeaParser {
 public:
  GpsTrack Parse(std::string_view bytes) {
    LineReader lines(bytes);
    std::string_view line;
    while (lines.Next(&line)) {
      const std::size_t dollar = line.find('$');  // loggers may write something before it
      if (dollar != line.npos) AddSentence(line.substr(dollar));
    }
    if (std::isfinite(first_day_)) {
      for (GpsFix& fix : track_.fixes) fix.time += kDay * first_day_;
    }
    return std::move(track_);
  }

 private:
  void AddSentence(std::string_view sentence) {
    const Fields fields = VerifiedFields(sentence);
    if (fields.empty()) {
      ++track_.skipped;
      return;
    }
    const std::string_view type = fields[0].size() == 5 ? fields[0].substr(2) : fields[0];
    if (type == "GGA") {
      AddFix(fields);
    } else if (type == "RMC") {
      AddDate(fields);
    } else if (type == "ZDA") {
      NoteTime(SecondsOfDay(FieldOf(fields, 1)));
      NoteDay(DayNumber(NumberOf(fields, 2), NumberOf(fields, 3), NumberOf(fields, 4)));
    }
  }
  void AddFix(const Fields& fields) {
    const double seconds = SecondsOfDay(FieldOf(fields, 1));
    const auto position = PositionOfGga(fields);
    if (!std::isfinite(seconds) || !position) {
      ++track_.skipped;
      return;
    }
    NoteTime(seconds);
    GpsFix fix;
    fix.time = kDay * days_ + seconds;
    fix.geodetic = position;
    if (times_.insert(fix.time).second) track_.fixes.push_back(fix);  // one talker is enough
  }
  // ddmmyy: two digits of the year, from 1980 on (the start of GPS time).
  void AddDate(const Fields& fields) {
    NoteTime(SecondsOfDay(FieldOf(fields, 1)));
    const double date = NumberOf(fields, 9);
    if (!(date >= 0.0 && date <= 311299.0)) return;
    const double day = std::floor(date / 1e4), year = std::fmod(date, 100.0);
    const double month = std::floor(std::fmod(date, 1e4) / 100.0);
    NoteDay(DayNumber(day, month, year + (year >= 80.0 ? 1900.0 : 2000.0)));
  }
  // Midnight is where the time of day jumps back by more than half a day.
  void NoteTime(double seconds) {
    if (!std::isfinite(seconds)) return;
    if (seconds < last_seconds_ - kDay / 2) ++days_;
    last_seconds_ = seconds;
  }
  void NoteDay(double day) {
    if (std::isfinite(day) && !std::isfinite(first_day_)) first_day_ = day - days_;
  }

  GpsTrack track_;
  std::set<double> times_;
  double days_ = 0.0, last_seconds_ = 0.0;
  double first_day_ = std::numeric_limits<double>::quiet_NaN();  // since 1970, of days_ = 0
};

}  // namespace

bool LooksLikeNmea(std::string_view bytes) {
  constexpr int kLines = 20;
  LineReader lines(bytes);
  std::string_view line;
  for (int i = 0; i < kLines && lines.Next(&line); ++i) {
    const std::size_t dollar = line.find('$');
    if (dollar == line.npos || dollar + 6 >= line.size()) continue;
    const std::string_view address = line.substr(dollar + 1, 5);
    const bool capitals = std::all_of(address.begin(), address.end(), [](char c) {
      return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    });
    if (capitals && line[dollar + 6] == ',') return true;
  }
  return false;
}

GpsTrack ParseNmea(std::string_view bytes) { return NmeaParser().Parse(bytes); }

}  // namespace planegraph
