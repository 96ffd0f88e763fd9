#include "planegraph/io/tile_file.h"

#include <signal.h>
#include <sys/resource.h>

#include <random>
#include <set>
#include <tuple>

#include "io/test_files.h"
#include "planegraph/base/parallel.h"

namespace planegraph {
namespace {

class TileFileTest : public TestFolder {
 protected:
  static Cloud Random(std::size_t count, bool normals = true, bool colors = true) {
    std::mt19937_64 engine(3);
    std::uniform_real_distribution<float> uniform(-60.0f, 70.0f);
    Cloud cloud;
    cloud.viewpoint = {1.0, 2.0, 3.0};
    for (std::size_t i = 0; i < count; ++i) {
      cloud.points.emplace_back(uniform(engine), uniform(engine), uniform(engine));
      if (normals) cloud.normals.emplace_back(uniform(engine), uniform(engine), uniform(engine));
      if (colors) cloud.colors.push_back({static_cast<std::uint8_t>(i), 1, 2});
    }
    return cloud;
  }

  static void Fill(const Cloud& cloud, std::size_t part, TileFile* file) {
    for (std::uint32_t first = 0; first < cloud.size(); first += part) {
      std::vector<std::uint32_t> indices;
      for (std::uint32_t i = first; i < std::min(first + part, cloud.size()); ++i) {
        indices.push_back(i);
      }
      file->Add(Select(cloud, indices));
    }
    file->Finish();
  }

  static void FillADiskOfAPage(const std::string& folder) {
    ::signal(SIGXFSZ, SIG_IGN);
    const ::rlimit limit{4096, 4096};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      TileFile file(folder, 10.0, 0);
      Fill(Random(1000), 100, &file);
    } catch (const InputError& error) {
      std::fprintf(stderr, "%s", error.what());
      ::_exit(2);
    }
    ::_exit(0);
  }

  static void ExpectSame(const CloudTiles& found, const CloudTiles& expected) {
    ASSERT_EQ(found.count(), expected.count());
    for (std::size_t t = 0; t < found.count(); ++t) {
      const Cloud a = found.Load(t), b = expected.Load(t);
      EXPECT_EQ(found.PointsOf(t), a.size());
      EXPECT_EQ(a.points, b.points);
      EXPECT_EQ(a.normals, b.normals);
      EXPECT_EQ(a.colors, b.colors);
      EXPECT_EQ(a.offset, b.offset);
      EXPECT_EQ(a.viewpoint, b.viewpoint);
    }
  }
};

TEST_F(TileFileTest, HoldsWhatTheTilesInMemoryHoldWhateverItsBuffer) {
  for (const bool normals : {false, true}) {
    for (const bool colors : {false, true}) {
      const Cloud cloud = Random(3000, normals, colors);
      for (const double edge : {7.0, 25.6, 1000.0}) {
        const TilesInMemory expected(cloud, edge);
        for (const std::size_t buffer : {0, 1000, 100000000}) {
          TileFile file(Path(""), edge, buffer);
          Fill(cloud, buffer == 0 ? 1 : 700, &file);
          ExpectSame(file, expected);
        }
      }
    }
  }
}

TEST_F(TileFileTest, NoPointIsLostAndNoneIsThereTwice) {
  const Cloud cloud = Random(5000);
  std::multiset<std::tuple<float, float, float>> all, found;
  for (const auto& p : cloud.points) all.insert({p.x(), p.y(), p.z()});
  TileFile file(Path(""), 12.8, 10000);
  Fill(cloud, 333, &file);
  EXPECT_EQ(file.Points(), cloud.size());
  for (std::size_t t = 0; t < file.count(); ++t) {
    const Cloud tile = file.Load(t);
    for (const auto& p : tile.points) {
      EXPECT_EQ(TileOf(p, 12.8), TileOf(tile.points.front(), 12.8));
      found.insert({p.x(), p.y(), p.z()});
    }
  }
  EXPECT_EQ(found, all);
}

TEST_F(TileFileTest, ThreadsReadAndLabelTilesInAnyOrder) {
  TileFile file(Path(""), 12.8, 10000);
  Fill(Random(5000), 333, &file);
  ParallelFor(file.count(), 4, [&](std::size_t k) {
    const std::size_t tile = file.count() - 1 - k;
    file.WriteLabels(tile, std::vector<std::int32_t>(file.Load(tile).size(), int(tile)));
  });
  for (std::size_t t = 0; t < file.count(); ++t) {
    EXPECT_EQ(file.ReadLabels(t), std::vector<std::int32_t>(file.PointsOf(t), int(t)));
  }
  EXPECT_THROW(file.WriteLabels(0, {}), std::invalid_argument);
}

TEST_F(TileFileTest, LeavesNothingBehind) {
  std::filesystem::create_directory(Path("scratch"));
  {
    TileFile file(Path("scratch"), 10.0, 0);
    Fill(Random(100), 10, &file);
    EXPECT_TRUE(std::filesystem::is_empty(Path("scratch"))) << "not even while it is used";
  }
  EXPECT_TRUE(std::filesystem::is_empty(Path("scratch")));
}

TEST_F(TileFileTest, AFolderThatTakesNothingIsAnInputError) {
  EXPECT_THROW(TileFile(Path("nowhere"), 10.0, 0), InputError);
  EXPECT_THROW(TileFile(Write("file", "x"), 10.0, 0), InputError);
}

// The kernel's own limit of a file's size stands for a full disk: both end a write early.
TEST_F(TileFileTest, AFullDiskIsAnInputError) {
  EXPECT_EXIT(FillADiskOfAPage(Path("")), testing::ExitedWithCode(2),
              "has no room for the scratch file");
}

TEST_F(TileFileTest, ADiskThatIsTooSmallIsKnownBefore) {
  CheckScratchRoom(Path(""), 1);
  CheckScratchRoom(Path("nowhere"), 1);
  try {
    CheckScratchRoom(Path(""), std::uint64_t{1} << 62);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(error.reason().find("has no room for the scratch file"), std::string::npos);
    EXPECT_EQ(error.file(), Path(""));
  }
}

TEST_F(TileFileTest, NothingIsAddedToFinishedTiles) {
  TileFile file(Path(""), 10.0, 0);
  Fill(Random(10), 10, &file);
  EXPECT_THROW(file.Add(Random(10)), std::logic_error);
  EXPECT_EQ(file.Points(), 10u);
}

TEST_F(TileFileTest, AScratchFileThatIsTooShortSaysSo) {
  ScratchFile file(Path(""));
  file.WriteAt(0, "abcd", 4);
  char read[8];
  try {
    file.ReadAt(0, read, 8);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(error.reason().find("shorter"), std::string::npos) << error.reason();
  }
}

TEST_F(TileFileTest, PartsOfDifferentCloudsAreRefused) {
  TileFile file(Path(""), 10.0, 0);
  file.Add(Random(10));
  file.Add(Cloud());
  EXPECT_THROW(file.Add(Random(10, false)), std::invalid_argument);
  Cloud moved = Random(10);
  moved.offset.x() = 1.0;
  EXPECT_THROW(file.Add(moved), std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
