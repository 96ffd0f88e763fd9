#include "planegraph/segmentation/planes_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/test_files.h"
#include "planegraph/segmentation/segmenter.h"
#include "segmentation/packed_array.h"
#include "segmentation/ray_world.h"

namespace planegraph {
namespace {

using ::testing::HasSubstr;

PlaneSet MakePlanes(CloudKind kind = CloudKind::kLaser,
                    const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
  RayScan scan = ScanWorld(FurnishedRoom(1), MakePose(0, 0, 1.3, 0.2), 15000, {}, 3);
  scan.cloud.offset = scan.cloud.viewpoint = offset;
  SegmentationOptions options;
  options.kind = kind;
  return SegmentPlanes(scan.cloud, options).planes;
}

void ExpectSame(const SupportMask& a, const SupportMask& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.u, b.u);
  EXPECT_EQ(a.v, b.v);
  EXPECT_EQ(a.cell_size, b.cell_size);
  EXPECT_EQ(std::tie(a.min_i, a.min_j, a.width, a.height),
            std::tie(b.min_i, b.min_j, b.width, b.height));
  EXPECT_EQ(a.cells, b.cells);
}

void ExpectSame(const PlaneSegment& a, const PlaneSegment& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.plane.normal, b.plane.normal);
  EXPECT_EQ(a.plane.distance, b.plane.distance);
  EXPECT_EQ(a.moments.count, b.moments.count);
  EXPECT_EQ(a.moments.mean, b.moments.mean);
  EXPECT_EQ(a.moments.scatter, b.moments.scatter);
  EXPECT_EQ(a.axes.values, b.axes.values);
  EXPECT_EQ(a.axes.vectors, b.axes.vectors);
  EXPECT_EQ(a.rms, b.rms);
  EXPECT_EQ(a.area, b.area);
  EXPECT_EQ(a.thickness, b.thickness);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.orientation, b.orientation);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.hull, b.hull);
  ExpectSame(a.mask, b.mask);
}

void ExpectSame(const Patch& a, const Patch& b) {
  EXPECT_EQ(a.moments.count, b.moments.count);
  EXPECT_EQ(a.moments.mean, b.moments.mean);
  EXPECT_EQ(a.moments.scatter, b.moments.scatter);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(std::tie(a.size, a.sigma, a.segment, a.orientation),
            std::tie(b.size, b.sigma, b.segment, b.orientation));
}

class PlanesFile : public TestFolder {};

TEST_F(PlanesFile, RoundTripIsExact) {
  for (const CloudKind kind : {CloudKind::kLaser, CloudKind::kVision}) {
    const PlaneSet before = MakePlanes(kind);
    WritePlanes(Path("planes.json"), before);
    const PlaneSet after = ReadPlanes(Path("planes.json"));
    EXPECT_EQ(after.kind, before.kind);
    EXPECT_EQ(after.viewpoint, before.viewpoint);
    EXPECT_EQ(after.offset, before.offset);
    EXPECT_EQ(after.point_count, before.point_count);
    EXPECT_EQ(after.noise.constant, before.noise.constant);
    EXPECT_EQ(after.noise.per_metre, before.noise.per_metre);
    EXPECT_EQ(after.range_image.nearest(), before.range_image.nearest());
    EXPECT_EQ(after.range_image.farthest(), before.range_image.farthest());
    EXPECT_EQ(after.range_image.viewpoint(), before.range_image.viewpoint());
    ASSERT_EQ(after.planes.size(), before.planes.size());
    ASSERT_EQ(after.patches.size(), before.patches.size());
    for (std::size_t i = 0; i < after.planes.size(); ++i) {
      ExpectSame(after.planes[i], before.planes[i]);
    }
    for (std::size_t i = 0; i < after.patches.size(); ++i) {
      ExpectSame(after.patches[i], before.patches[i]);
    }
  }
}

TEST_F(PlanesFile, AnEmptySetIsAFileToo) {
  const PlaneSet after = ParsePlanes(FormatPlanes(PlaneSet()), "empty");
  EXPECT_TRUE(after.planes.empty());
  EXPECT_TRUE(after.patches.empty());
  EXPECT_TRUE(after.range_image.empty());
}

TEST_F(PlanesFile, PlanesAreInTheCloudsOwnFrame) {
  const Eigen::Vector3d offset(4e5, 5.7e6, 100.0);
  const PlaneSet set = MakePlanes(CloudKind::kLaser, offset);
  const auto json = nlohmann::json::parse(FormatPlanes(set));
  for (const auto& plane : json["planes"]) {
    const auto n = plane["normal"].get<std::vector<double>>();
    for (const auto& corner : plane["hull"]) {
      const auto p = corner.get<std::vector<double>>();
      EXPECT_NEAR(n[0] * p[0] + n[1] * p[1] + n[2] * p[2], plane["distance"].get<double>(), 1e-6);
      EXPECT_NEAR(p[1], offset.y(), 20.0);
    }
  }
  const PlaneSet after = ParsePlanes(FormatPlanes(set), "far");
  for (std::size_t i = 0; i < set.planes.size(); ++i) {
    EXPECT_NEAR(after.planes[i].plane.distance, set.planes[i].plane.distance, 1e-7);
    EXPECT_LT((after.planes[i].centroid() - set.planes[i].centroid()).norm(), 1e-8);
  }
}

TEST_F(PlanesFile, TheStampComesAlong) {
  const auto json = nlohmann::json::parse(FormatPlanes(PlaneSet(), R"({"seconds": 1.5})"));
  EXPECT_EQ(json["seconds"], 1.5);
}

std::string Complaint(const nlohmann::json& json) {
  try {
    ParsePlanes(json.dump(), "x.json");
  } catch (const InputError& error) {
    EXPECT_EQ(error.file(), "x.json");
    return error.what();
  }
  return "accepted";
}

TEST_F(PlanesFile, ComplaintsNameThePlace) {
  const auto good = nlohmann::json::parse(FormatPlanes(MakePlanes()));
  ASSERT_EQ(Complaint(good), "accepted");
  const std::vector<std::tuple<const char*, nlohmann::json, const char*>> changes = {
      {"/planes/1/normal", {1.0, 1.0, 0.0}, "planes[1].normal: a unit vector"},
      {"/planes/0/normal", {1.0, 0.0}, "planes[0].normal: three numbers"},
      {"/planes/0/area", "big", "planes[0].area: a number"},
      {"/planes/0/area", -1.0, "planes[0].area: the number is out of range"},
      {"/planes/0/centroid/2", nullptr, "planes[0].centroid[2]: a number"},
      {"/planes/0/centroid/2", 1e200, "planes[0].centroid: the number is out of range"},
      {"/planes/0/source", "sonar", "planes[0].source: 'laser' or 'vision'"},
      {"/planes/0/mask/bits", "AAAA", "planes[0].mask.bits: base64"},
      {"/planes/0/mask/width", 1 << 20, "planes[0].mask.width: the number is out of range"},
      {"/planes/0/id", 1.5, "planes[0].id: an integer"},
      {"/planes", 7, "planes: an array"},
      {"/patches/values", "A", "patches.values: base64"},
      {"/patches/count", 1, "patches.count: does not fit"},
      {"/patches/sides", "A", "patches.sides: base64"},
      {"/patches/sides", "", "patches.sides: base64"},
      {"/patches/sides", 7, "patches.sides"},
      {"/range_image/ranges", "", "range_image.ranges: too few"},
      {"/noise", nlohmann::json::object(), "noise.constant: is missing"},
  };
  for (const auto& [place, value, complaint] : changes) {
    auto changed = good;
    changed[nlohmann::json::json_pointer(place)] = value;
    EXPECT_THAT(Complaint(changed), HasSubstr(complaint)) << place;
  }
}

TEST_F(PlanesFile, PatchesAreChecked) {
  auto json = nlohmann::json::parse(FormatPlanes(MakePlanes()));
  auto segments = *UnpackArray<std::int32_t>(json["patches"]["segments"].get<std::string>());
  segments[3] = static_cast<std::int32_t>(json["planes"].size());
  auto changed = json;
  changed["patches"]["segments"] = PackArray(segments);
  EXPECT_THAT(Complaint(changed), HasSubstr("patch 3 is not valid"));
  auto values = *UnpackArray<double>(json["patches"]["values"].get<std::string>());
  values[15 * 5 + 1] = NAN;
  changed = json;
  changed["patches"]["values"] = PackArray(values);
  EXPECT_THAT(Complaint(changed), HasSubstr("patch 5 is not valid"));
}

TEST_F(PlanesFile, WithoutSidesAPatchIsAsItsPlane) {
  auto json = nlohmann::json::parse(FormatPlanes(MakePlanes(CloudKind::kVision)));
  json["patches"].erase("sides");
  for (const char* word : {"unknown", "sensor"}) {
    for (auto& plane : json["planes"]) plane["orientation"] = word;
    const PlaneSet set = ParsePlanes(json.dump(), "old");
    for (const Patch& patch : set.patches) {
      EXPECT_EQ(patch.orientation == Orientation::kSensor, word == std::string("sensor"));
    }
  }
}

TEST_F(PlanesFile, BrokenFiles) {
  EXPECT_THROW(ReadPlanes(Path("missing.json")), InputError);
  for (const char* text : {"", "[]", "{", "null", "{\"planes\": []}", "{\"kind\": 1e999}"}) {
    EXPECT_THROW(ReadPlanes(Write("broken.json", text)), InputError) << text;
  }
  const std::string whole = FormatPlanes(MakePlanes());
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 50) {
    EXPECT_THROW(ParsePlanes(whole.substr(0, size), "cut"), InputError) << size;
  }
}

TEST(PackedArray, Base64OfTheStandard) {
  // RFC 4648, section 10.
  const std::pair<const char*, const char*> vectors[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : vectors) {
    EXPECT_EQ(EncodeBase64(plain), coded);
    EXPECT_EQ(DecodeBase64(coded), plain);
  }
  for (const char* bad : {"Z", "Zg", "Zg=", "Z===", "Zm9*", "Zg==Zg=="}) {
    EXPECT_FALSE(DecodeBase64(bad)) << bad;
  }
}

TEST(PackedArray, Bits) {
  const std::vector<std::uint8_t> flags = {1, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  EXPECT_EQ(PackBits(flags), EncodeBase64(std::string("\x01\x02")));
  EXPECT_EQ(UnpackBits(PackBits(flags), 10), flags);
  EXPECT_FALSE(UnpackBits(PackBits(flags), 20));
}

}  // namespace
}  // namespace planegraph
