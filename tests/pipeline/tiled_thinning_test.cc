#include "pipeline/tiled_thinning.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "planegraph/cloud/cloud_tiles.h"
#include "planegraph/cloud/voxel_key.h"
#include "planegraph/evaluation/scan_merge.h"

namespace planegraph {
namespace {

Cloud Random(std::size_t count) {
  std::mt19937_64 engine(4);
  std::uniform_real_distribution<float> uniform(-12.0f, 12.0f);
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    cloud.points.emplace_back(uniform(engine), uniform(engine), 0.1f * uniform(engine));
  }
  return cloud;
}

// Voxels that do and do not divide a tile, and such as hold several tiles.
TEST(TiledThinning, KeepsOnePointOfEachVoxel) {
  const Cloud cloud = Random(20000);
  for (const double tile : {0.8, 3.2, 25.6}) {
    const TilesInMemory tiles(cloud, tile);
    for (const double voxel : {0.05, 0.1, 0.37, 0.8, 3.0, 7.3, 40.0}) {
      TiledThinning thinning(voxel, tile);
      std::set<std::uint64_t> voxels, expected;
      std::size_t kept = 0;
      for (std::size_t t = 0; t < tiles.count(); ++t) {
        const Cloud part = tiles.Load(t);
        for (const std::uint32_t i : thinning.Keep(part, FirstOfEachVoxel(part, voxel))) {
          voxels.insert(VoxelKey(part.Position(i), voxel));
          ++kept;
        }
      }
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        expected.insert(VoxelKey(cloud.Position(i), voxel));
      }
      EXPECT_EQ(kept, voxels.size()) << tile << " " << voxel << ": one of each";
      EXPECT_EQ(voxels, expected) << tile << " " << voxel;
    }
  }
}

TEST(TiledThinning, WithoutAVoxelAllPointsStay) {
  const Cloud cloud = Random(10);
  const std::vector<std::uint32_t> points = {1, 3, 3, 9};
  EXPECT_EQ(TiledThinning(0.0, 3.2).Keep(cloud, points), points);
}

}  // namespace
}  // namespace planegraph
