// Fails where an include goes up in the order of the modules, and proves on a small tree of its own
// that it would.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "layering/layers.h"

namespace planegraph::layering {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Layering, TheRepositoryKeepsTheOrder) {
  EXPECT_THAT(FindViolations(PLANEGRAPH_SOURCE_DIR), IsEmpty());
}

TEST(Layering, TheOrderIsReadFromTheBuild) {
  const Layers layers = ParseLayers(
      "planegraph_add_module(base DEPENDS Threads::Threads)\n"
      "planegraph_add_module(cloud\n   DEPENDS planegraph_base)\n"
      "planegraph_add_module(io DEPENDS planegraph_cloud PRIVATE_DEPENDS yaml-cpp)\n");
  EXPECT_THAT(layers.at("base"), IsEmpty());
  EXPECT_THAT(layers.at("io"), ElementsAre("base", "cloud"));
}

TEST(Layering, ADependencyUpwardsIsRefused) {
  EXPECT_THROW(ParseLayers("planegraph_add_module(base DEPENDS planegraph_io)\n"
                           "planegraph_add_module(io DEPENDS planegraph_base)\n"),
               std::runtime_error);
}

// A tree with four modules: base, then geometry, then graph and evaluation side by side.
class SmallTree : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("planegraph_layering_" + std::to_string(getpid()));
    Write("src/CMakeLists.txt",
          "planegraph_add_module(base DEPENDS Threads::Threads)\n"
          "planegraph_add_module(geometry DEPENDS planegraph_base)\n"
          "planegraph_add_module(graph DEPENDS planegraph_geometry)\n"
          "planegraph_add_module(evaluation DEPENDS planegraph_geometry)\n");
  }
  void TearDown() override { fs::remove_all(root_); }

  void Write(const std::string& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }

  // The violations of a tree whose file `path` has one include on its second line.
  std::vector<std::string> WithInclude(const std::string& path, const std::string& include) {
    Write(path, "// A comment.\n#include " + include + "\n");
    return FindViolations(root_);
  }

  fs::path root_;
};

TEST_F(SmallTree, AnIncludeDownwardsIsFine) {
  EXPECT_THAT(WithInclude("src/graph/a.cc", "\"planegraph/base/error.h\""), IsEmpty());
  EXPECT_THAT(WithInclude("src/graph/b.cc", "<vector>"), IsEmpty());
  EXPECT_THAT(WithInclude("src/graph/c.cc", "\"ceres/problem.h\""), IsEmpty());
  EXPECT_THAT(WithInclude("src/geometry/d.cc", "<nlohmann/json.hpp>"), IsEmpty());
  EXPECT_THAT(WithInclude("tools/e.cc", "\"tools/command.h\""), IsEmpty());
}

TEST_F(SmallTree, AnIncludeUpwardsIsFound) {
  EXPECT_THAT(WithInclude("src/base/a.cc", "\"planegraph/graph/graph.h\""),
              ElementsAre("src/base/a.cc:2: graph does not lie below base"));
}

TEST_F(SmallTree, APublicHeaderUpwardsIsFound) {
  EXPECT_THAT(WithInclude("include/planegraph/base/a.h", "<planegraph/geometry/plane.h>"),
              ElementsAre(HasSubstr("geometry does not lie below base")));
}

TEST_F(SmallTree, APrivateHeaderUpwardsIsFound) {
  EXPECT_THAT(WithInclude("src/geometry/a.cc", "\"graph/internal.h\""),
              ElementsAre(HasSubstr("graph does not lie below geometry")));
}

TEST_F(SmallTree, AnIncludeSidewaysIsFound) {
  EXPECT_THAT(WithInclude("src/evaluation/a.cc", "\"planegraph/graph/graph.h\""),
              ElementsAre(HasSubstr("graph does not lie below evaluation")));
}

TEST_F(SmallTree, FactorsSeeTheGraphAndNoMore) {
  EXPECT_THAT(WithInclude("factors/a.cc", "\"planegraph/graph/graph.h\""), IsEmpty());
  EXPECT_THAT(WithInclude("factors/a.cc", "\"planegraph/evaluation/ate.h\""),
              ElementsAre(HasSubstr("factors see only")));
}

TEST_F(SmallTree, ToolsAreIncludedByToolsAlone) {
  EXPECT_THAT(WithInclude("src/graph/a.cc", "\"tools/command.h\""),
              ElementsAre(HasSubstr("nothing includes tools/")));
}

TEST_F(SmallTree, CeresStaysInItsRooms) {
  EXPECT_THAT(WithInclude("src/evaluation/a.cc", "<ceres/ceres.h>"),
              ElementsAre(HasSubstr("Ceres is for graph")));
}

TEST_F(SmallTree, PublicHeadersHideOtherLibraries) {
  for (const char* library :
       {"<nlohmann/json.hpp>", "<yaml-cpp/yaml.h>", "<nanoflann.hpp>", "<pcl/point_types.h>",
        "<embree3/rtcore.h>", "<GeographicLib/Geocentric.hpp>", "<libexif/exif-data.h>"}) {
    EXPECT_THAT(WithInclude("include/planegraph/graph/a.h", library),
                ElementsAre(HasSubstr("no public header shows")))
        << library;
  }
}

}  // namespace
}  // namespace planegraph::layering
