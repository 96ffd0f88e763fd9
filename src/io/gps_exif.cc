// Positions in the EXIF of images, by libexif.
#include <libexif/exif-data.h>
#include <libexif/exif-loader.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>

#include "io/gps_formats.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct LoaderDeleter {
  void operator()(ExifLoader* loader) const { exif_loader_unref(loader); }
};
struct DataDeleter {
  void operator()(ExifData* data) const { exif_data_unref(data); }
};
using Loader = std::unique_ptr<ExifLoader, LoaderDeleter>;
using Data = std::unique_ptr<ExifData, DataDeleter>;

// The tags of the EXIF standard's GPS directory; their numbers mean other things elsewhere.
enum GpsTag { kLatitudeRef = 1, kLatitude, kLongitudeRef, kLongitude, kAltitudeRef, kAltitude };

const ExifEntry* GpsEntry(const Data& data, GpsTag tag) {
  return exif_content_get_entry(data->ifd[EXIF_IFD_GPS], static_cast<ExifTag>(tag));
}

double RationalOf(const Data& data, const ExifEntry* entry, std::size_t index) {
  constexpr std::size_t kBytes = 8;
  if (!entry || entry->format != EXIF_FORMAT_RATIONAL || entry->size < kBytes * (index + 1)) {
    return kNaN;
  }
  const ExifRational value =
      exif_get_rational(entry->data + kBytes * index, exif_data_get_byte_order(data.get()));
  return value.denominator == 0 ? kNaN : static_cast<double>(value.numerator) / value.denominator;
}

char FirstByte(const ExifEntry* entry) {
  return entry && entry->data && entry->size > 0 ? static_cast<char>(entry->data[0]) : '\0';
}

// Degrees, minutes and seconds; the letter of the other hemisphere turns the sign.
double AngleOf(const Data& data, GpsTag tag, GpsTag reference, char positive, char negative) {
  const ExifEntry* entry = GpsEntry(data, tag);
  const char letter = FirstByte(GpsEntry(data, reference));
  if (letter != positive && letter != negative) return kNaN;
  const double angle = RationalOf(data, entry, 0) + RationalOf(data, entry, 1) / 60.0 +
                       RationalOf(data, entry, 2) / 3600.0;
  return letter == positive ? angle : -angle;
}

std::optional<GeodeticPosition> PositionOf(const Data& data) {
  if (!data) return std::nullopt;
  const double altitude = RationalOf(data, GpsEntry(data, kAltitude), 0);
  const bool below = FirstByte(GpsEntry(data, kAltitudeRef)) == 1;
  const GeodeticPosition position{AngleOf(data, kLatitude, kLatitudeRef, 'N', 'S'),
                                  AngleOf(data, kLongitude, kLongitudeRef, 'E', 'W'),
                                  below ? -altitude : altitude};
  if (!IsOnEarth(position)) return std::nullopt;
  return position;
}

// EXIF stands at the start of a file, in one segment of at most 64 KB behind others: more need not
// be read.
std::string ReadStart(const std::string& path) {
  constexpr std::size_t kMost = 1 << 20;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError::InFile(path, "cannot be read");
  std::string bytes(kMost, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(kMost));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

std::vector<fs::path> ImagesOf(const std::string& folder) {
  std::vector<fs::path> images;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string ending = ToLower(entry.path().extension().string());
    if (ending == ".jpg" || ending == ".jpeg") images.push_back(entry.path());
  }
  if (error) throw InputError::InFile(folder, "cannot be listed: " + error.message());
  if (images.empty()) throw InputError::InFile(folder, "is a folder without .jpg images");
  std::sort(images.begin(), images.end());
  return images;
}

}  // namespace

std::optional<GeodeticPosition> ParseExifPosition(std::string_view bytes) {
  const Loader loader(exif_loader_new());
  if (!loader) throw std::bad_alloc();
  std::string copy(bytes.substr(0, std::numeric_limits<unsigned int>::max()));
  exif_loader_write(loader.get(), reinterpret_cast<unsigned char*>(copy.data()),
                    static_cast<unsigned int>(copy.size()));
  return PositionOf(Data(exif_loader_get_data(loader.get())));
}

GpsTrack ReadExifFolder(const std::string& folder) {
  GpsTrack track;
  track.by_image = true;
  for (const fs::path& path : ImagesOf(folder)) {
    GpsFix fix;
    fix.image = path.filename().string();
    fix.geodetic = ParseExifPosition(ReadStart(path.string()));
    if (fix.geodetic) {
      track.fixes.push_back(std::move(fix));
    } else {
      ++track.skipped;
    }
  }
  return track;
}

}  // namespace planegraph
