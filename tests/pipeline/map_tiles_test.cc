#include "pipeline/map_tiles.h"

#include <algorithm>

#include "io/test_files.h"
#include "planegraph/io/cloud_io.h"

namespace planegraph {
namespace {

class MapTilesTest : public TestFolder {
 protected:
  static std::string Header(std::size_t points) {
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points) +
           "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  }
};

TEST_F(MapTilesTest, TheMemoryOfAWholeCloudIsKnownFromItsHeader) {
  const std::string text = Header(2) + "no numbers here\nnor anywhere\n";
  const auto bytes = BytesAsAWhole(Write("a.ply", text));
  ASSERT_TRUE(bytes);
  EXPECT_GT(*bytes, text.size());
  EXPECT_FALSE(BytesAsAWhole(Write("a.xyz", "1 2 3\n4 5 6\n")));
}

// The points stand on either side of a large one, so that only a second census knows their tiles.
TEST_F(MapTilesTest, TilesDoNotDependOnWhereTheOffsetIsFound) {
  const std::string near = "0.5 0.5 0\n", far = "500000.25 600000.5 3\n";
  std::string many;
  for (int i = 0; i < 70000; ++i) many += near;
  const std::string early = Write("early.ply", Header(70001) + far + many);
  const std::string late = Write("late.ply", Header(70001) + many + far);
  MapMemory memory;
  memory.bytes = 1 << 24;
  memory.scratch = Path("");
  const TiledCloud a = SpillCloud(early, Sim3(), memory, 1),
                   b = SpillCloud(late, Sim3(), memory, 1);
  EXPECT_EQ(a.shift, b.shift);
  EXPECT_GT(a.shift.x(), 1e5);
  EXPECT_EQ(a.tiles->edge(), b.tiles->edge());
  ASSERT_EQ(a.tiles->count(), b.tiles->count());
  for (std::size_t t = 0; t < a.tiles->count(); ++t) {
    EXPECT_EQ(a.tiles->Load(t).points, b.tiles->Load(t).points);
  }
}

TEST_F(MapTilesTest, TilesThatStayTooFullSayWhatTheyTake) {
  std::string points;
  for (int i = 0; i < 2000; ++i) points += std::to_string(i * 1e-3) + " 0.5 0\n";
  const std::string path = Write("a.ply", Header(2000) + points);
  MapMemory memory;
  memory.scratch = Path("");
  memory.bytes = 100000;
  const TiledCloud too_full = SpillCloud(path, Sim3(), memory, 1);
  ASSERT_TRUE(too_full.bytes_of_too_full);
  EXPECT_GT(*too_full.bytes_of_too_full, memory.bytes);
  memory.bytes = *too_full.bytes_of_too_full;
  EXPECT_FALSE(SpillCloud(path, Sim3(), memory, 1).bytes_of_too_full) << "as it said";
}

TEST_F(MapTilesTest, TheUserIsWarnedOfTilesThatStayTooFull) {
  std::string points;
  for (int i = 0; i < 2000; ++i) points += std::to_string(i * 1e-3) + " 0.5 0\n";
  Site site;
  site.maps.emplace_back();
  site.maps[0].cloud = Write("a.ply", Header(2000) + points);
  MapMemory memory;
  memory.scratch = Path("");
  memory.bytes = 100000;
  std::vector<std::string> warnings;
  PrepareMap(site, 0, 1, &warnings, memory);
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("fullest tiles") != std::string::npos;
  }));
}

}  // namespace
}  // namespace planegraph
