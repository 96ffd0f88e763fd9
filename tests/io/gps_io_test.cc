#include "planegraph/io/gps_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "io/exif_bytes.h"
#include "io/gps_formats.h"

namespace planegraph {
namespace {

using testing::HasSubstr;

class GpsIo : public TestFolder {
 protected:
  GpsTrack Read(const std::string& text) const { return ReadGps(Write("gps", text)); }
  std::string ErrorOf(const std::string& text) const {
    try {
      Read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "(no error)";
  }
};

TEST_F(GpsIo, CsvByTime) {
  const GpsTrack track = Read("time,lat,lon,alt\n1000.5,51.4,-7.5,149.6\n1001.5,-51.5,7.6,-3\n");
  EXPECT_FALSE(track.metric);
  EXPECT_FALSE(track.by_image);
  ASSERT_EQ(track.fixes.size(), 2u);
  EXPECT_EQ(track.fixes[0].time, 1000.5);
  EXPECT_EQ(track.fixes[0].geodetic->latitude, 51.4);
  EXPECT_EQ(track.fixes[0].geodetic->longitude, -7.5);
  EXPECT_EQ(track.fixes[1].geodetic->altitude, -3.0);
}

TEST_F(GpsIo, ColumnsGoByTheirNames) {
  const std::string same[] = {
      "image,lat,lon,alt\na.jpg,1,2,3\n", "alt,note,lng,latitude,file\n3,hello,2,1,a.jpg\n",
      "\xEF\xBB\xBF"
      "Filename;Altitude;Longitude;Latitude\r\n\"a.jpg\"; 3 ;2;1\r\n",
      "# comment\n\nname\theight\tlong\tlat\na.jpg\t3\t2\t1\n", "image lat lon ele\n a.jpg 1 2 3"};
  for (const auto& text : same) {
    SCOPED_TRACE(text);
    const GpsTrack track = Read(text);
    EXPECT_TRUE(track.by_image);
    ASSERT_EQ(track.fixes.size(), 1u);
    EXPECT_EQ(track.fixes[0].image, "a.jpg");
    EXPECT_TRUE(std::isnan(track.fixes[0].time));
    EXPECT_EQ(track.fixes[0].geodetic->latitude, 1.0);
    EXPECT_EQ(track.fixes[0].geodetic->longitude, 2.0);
    EXPECT_EQ(track.fixes[0].geodetic->altitude, 3.0);
  }
}

TEST_F(GpsIo, MetricPositions) {
  for (const char* header : {"image,x,y,z", "image,easting,northing,height"}) {
    const GpsTrack track = Read(std::string(header) + "\na.jpg,393123.5,5707456.25,112\n");
    EXPECT_TRUE(track.metric);
    EXPECT_FALSE(track.fixes[0].geodetic.has_value());
    EXPECT_EQ(track.fixes[0].metric, Eigen::Vector3d(393123.5, 5707456.25, 112));
  }
}

TEST_F(GpsIo, RowsWithoutAPositionArePassedOver) {
  const GpsTrack track = Read("image,lat,lon,alt\na.jpg,,,\nb.jpg,1,2,3\nc.jpg,1\n");
  EXPECT_EQ(track.fixes.size(), 1u);
  EXPECT_EQ(track.skipped, 2u);
}

TEST_F(GpsIo, DamagedCsvIsNamed) {
  const struct {
    std::string text, expected;
  } cases[] = {{"", "is empty"},
               {"time,lat,lon\n1,2,3\n", ":1: the first line names no column `alt`"},
               {"lat,lon,alt\n1,2,3\n", ":1: the first line names neither"},
               {"1,2,3,4\n", ":1: the first line names no column `lat`"},
               {"time,lat,lon,alt\n", "holds no position"},
               {"time,lat,lon,alt\n1,2,,4\n", "holds no position (1 rows"},
               {"time,lat,lon,alt\n1,91,3,4\n", ":2: the position is not on earth"},
               {"time,lat,lon,alt\n1,9,-181,4\n", ":2: the position is not on earth"},
               {"time,lat,lon,alt\n1,9,1,4e6\n", ":2: the position is not on earth"},
               {"time,lat,lon,alt\n1,nan,1,4\n", ":2: lat is not a finite number: 'nan'"},
               {"time,lat,lon,alt\n1,5,1,4\n,5,1,4\n", ":3: the time is missing"},
               {"time,lat,lon,alt\n1,5,1,x4\n", ":2: alt is not a finite number"},
               {"image,lat,lon,alt\n,5,1,4\n", ":2: the name of the image"},
               {"image,lat,lon,alt\na,5,1,4\n\na,5,1,4\n", ":4: the image a occurs twice"}};
  for (const auto& c : cases) EXPECT_THAT(ErrorOf(c.text), HasSubstr(c.expected)) << c.text;
  EXPECT_THROW(ReadGps(Path("none.csv")), InputError);
}

TEST_F(GpsIo, ImageTimes) {
  const ImageTimes times = ReadImageTimes(Write("t.csv", "file,time\na.jpg,1.5\nb.jpg,2\n"));
  EXPECT_EQ(times.times, (std::vector<double>{1.5, 2.0}));
  EXPECT_EQ(times.files, (std::vector<std::string>{"a.jpg", "b.jpg"}));
  EXPECT_THROW(ReadImageTimes(Write("u.csv", "time,file\nx,a\n")), InputError);
  EXPECT_THROW(ReadImageTimes(Write("v.csv", "time,file\n")), InputError);
  EXPECT_THROW(ReadImageTimes(Write("w.csv", "file\na\n")), InputError);
}

// ---- NMEA ----

std::string Sentence(const std::string& body) {
  int sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof(end), "*%02X\r\n", static_cast<unsigned>(sum));
  return "$" + body + end;
}
std::string Gga(const std::string& time, const std::string& rest = "1,08,0.9,100.0,M,,M,,") {
  return Sentence("GNGGA," + time + ",5129.2800,N,00729.5800,E," + rest);
}

// The sentences that every description of NMEA has, checksums included.
TEST_F(GpsIo, NmeaOfTheTextbook) {
  const GpsTrack track = Read(
      "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"
      "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n");
  ASSERT_EQ(track.fixes.size(), 1u);
  EXPECT_NEAR(track.fixes[0].geodetic->latitude, 48.0 + 7.038 / 60.0, 1e-12);
  EXPECT_NEAR(track.fixes[0].geodetic->longitude, 11.0 + 31.0 / 60.0, 1e-12);
  EXPECT_NEAR(track.fixes[0].geodetic->altitude, 545.4 + 46.9, 1e-12);
  // 1994-03-23 12:35:19 UTC.
  EXPECT_EQ(track.fixes[0].time, 764426119.0);
  EXPECT_EQ(track.skipped, 0u);
}

TEST_F(GpsIo, NmeaWithoutADateCountsFromMidnightAndOverIt) {
  const GpsTrack track = Read(Gga("235959.50") + Gga("000000.50") + Gga("000001.50"));
  ASSERT_EQ(track.fixes.size(), 3u);
  EXPECT_NEAR(track.fixes[0].time, 86399.5, 1e-6);
  EXPECT_NEAR(track.fixes[1].time, 86400.5, 1e-6);
  EXPECT_NEAR(track.fixes[2].time, 86401.5, 1e-6);
}

TEST_F(GpsIo, ADateBehindMidnightDatesTheFixesBefore) {
  const GpsTrack track = Read(Gga("235959.00") + Gga("000001.00") +
                              Sentence("GNRMC,000001.00,A,5129.2800,N,00729.5800,E,0,0,010170,,"));
  EXPECT_EQ(track.fixes[0].time, 100.0 * 365.25 * 86400.0 - 1.0);  // 2070-01-01 less a second
  EXPECT_EQ(track.fixes[1].time - track.fixes[0].time, 2.0);
  const GpsTrack zda = Read(Gga("000001.00") + Sentence("GPZDA,000002.00,02,01,1970,00,00"));
  EXPECT_EQ(zda.fixes[0].time, 86401.0);
}

TEST_F(GpsIo, SouthWestAndNoFix) {
  const GpsTrack track =
      Read(Sentence("GPGGA,000001,3330.0000,S,07030.0000,W,2,08,0.9,10.0,M,,M,,") +
           Sentence("GPGGA,000002,3330.0000,S,07030.0000,W,0,00,,,M,,M,,") +
           Gga("000003", "1,8,1,,M,,M,,"));
  ASSERT_EQ(track.fixes.size(), 1u);
  EXPECT_NEAR(track.fixes[0].geodetic->latitude, -33.5, 1e-12);
  EXPECT_NEAR(track.fixes[0].geodetic->longitude, -70.5, 1e-12);
  EXPECT_EQ(track.skipped, 2u);
}

TEST_F(GpsIo, WrongChecksumsAreCounted) {
  std::string bad = Gga("000002");
  bad[10] = '9';
  const GpsTrack track = Read("started\n" + Gga("000001") + bad + "$GNGGA,000003\n" + "12:00 " +
                              Gga("000004") + Gga("000004"));
  ASSERT_EQ(track.fixes.size(), 2u);
  EXPECT_EQ(track.fixes[1].time, 4.0);
  EXPECT_EQ(track.skipped, 2u);
  EXPECT_THAT(ErrorOf(bad + bad), HasSubstr("holds no position (2 rows"));
  EXPECT_THAT(ErrorOf(Sentence("GPGGA,,,,,,0,,,,,,,,")), HasSubstr("holds no position"));
}

// ---- EXIF ----

ExifBytes WholePosition() {
  return ExifBytes()
      .Letter(1, 'S')
      .Rationals(2, {46000, 50000, 33385}, 1000)
      .Letter(3, 'W')
      .Rationals(4, {91000, 59000, 40416}, 1000)
      .Byte(5, 0)
      .Rationals(6, {198309}, 1000);
}

TEST_F(GpsIo, ExifFolder) {
  Write("images/b.JPG", WholePosition().Jpeg());
  Write("images/a.jpeg", WholePosition().Jpeg());
  Write("images/c.jpg", "\xFF\xD8\xFF\xD9");
  Write("images/notes.txt", "none");
  const GpsTrack track = ReadGps(Path("images"));
  EXPECT_TRUE(track.by_image);
  EXPECT_EQ(track.skipped, 1u);
  ASSERT_EQ(track.fixes.size(), 2u);
  EXPECT_EQ(track.fixes[0].image, "a.jpeg");
  EXPECT_EQ(track.fixes[1].image, "b.JPG");
  EXPECT_NEAR(track.fixes[0].geodetic->latitude, -(46.0 + 50.0 / 60 + 33.385 / 3600), 1e-12);
  EXPECT_NEAR(track.fixes[0].geodetic->longitude, -(91.0 + 59.0 / 60 + 40.416 / 3600), 1e-12);
  EXPECT_NEAR(track.fixes[0].geodetic->altitude, 198.309, 1e-12);
}

TEST_F(GpsIo, ExifBelowTheSea) {
  const auto position = ParseExifPosition(ExifBytes()
                                              .Letter(1, 'N')
                                              .Rationals(2, {31, 30, 0}, 1)
                                              .Letter(3, 'E')
                                              .Rationals(4, {35, 30, 0}, 1)
                                              .Byte(5, 1)
                                              .Rationals(6, {430}, 1)
                                              .Jpeg());
  ASSERT_TRUE(position.has_value());
  EXPECT_EQ(position->latitude, 31.5);
  EXPECT_EQ(position->altitude, -430.0);
}

TEST_F(GpsIo, IncompleteExifIsNoPosition) {
  EXPECT_FALSE(ParseExifPosition(ExifBytes().Letter(1, 'N').Jpeg()));
  EXPECT_FALSE(ParseExifPosition(WholePosition().Letter(1, 'X').Jpeg().substr(0, 60)));
  const auto latitude = [](const std::vector<std::uint32_t>& degrees, std::uint32_t denominator) {
    return ParseExifPosition(ExifBytes()
                                 .Letter(1, 'N')
                                 .Rationals(2, degrees, denominator)
                                 .Letter(3, 'E')
                                 .Rationals(4, {7, 0, 0}, 1)
                                 .Rationals(6, {1}, 1)
                                 .Jpeg());
  };
  EXPECT_TRUE(latitude({50, 0, 0}, 1));
  EXPECT_FALSE(latitude({50, 0, 0}, 0));
  EXPECT_FALSE(latitude({95, 0, 0}, 1));
  EXPECT_FALSE(latitude({50}, 1));
  const std::string whole = WholePosition().Jpeg();
  for (std::size_t length = 0; length < whole.size(); length += 3) {
    ParseExifPosition(whole.substr(0, length));  // any answer, but no crash
  }
}

TEST_F(GpsIo, FoldersWithoutPositionsAreNamed) {
  Write("none/readme.txt", "x");
  Write("plain/a.jpg", "\xFF\xD8\xFF\xD9");
  for (const auto& [folder, reason] : {std::pair{"none", "without .jpg images"},
                                       std::pair{"plain", "holds no position (1 rows"}}) {
    try {
      ReadGps(Path(folder));
      FAIL();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(reason));
    }
  }
}

TEST_F(GpsIo, RealImagesSayWhatTheirListSays) {
  const std::string base = std::string(PLANEGRAPH_SHARED_DATA) + "/photogrammetry/brighton_beach/";
  if (!std::filesystem::exists(base)) GTEST_SKIP() << "no " << base;
  const GpsTrack exif = ReadGps(base + "images"), list = ReadGps(base + "gps_exif.csv");
  ASSERT_EQ(exif.fixes.size(), 18u);
  ASSERT_EQ(list.fixes.size(), 18u);
  for (std::size_t i = 0; i < 18; ++i) {
    EXPECT_EQ(exif.fixes[i].image, list.fixes[i].image);
    EXPECT_NEAR(exif.fixes[i].geodetic->latitude, list.fixes[i].geodetic->latitude, 1e-9);
    EXPECT_NEAR(exif.fixes[i].geodetic->longitude, list.fixes[i].geodetic->longitude, 1e-9);
    EXPECT_NEAR(exif.fixes[i].geodetic->altitude, list.fixes[i].geodetic->altitude, 1e-3);
  }
}

}  // namespace
}  // namespace planegraph
