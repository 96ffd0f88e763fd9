// One point far off everything: an error of the file, which is named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "io/test_files.h"
#include "planegraph/base/error.h"
#include "planegraph/pipeline/front_end.h"
#include "planegraph/pipeline/map_front_end.h"

namespace planegraph {
namespace {

using ::testing::HasSubstr;

class FarPoints : public TestFolder {
 protected:
  // A square of ground, and a point three thousand kilometres above it.
  std::string CloudFile() const {
    std::string text;
    for (int k = 0; k < 2500; ++k) {
      text += std::to_string(0.1 * (k % 50)) + " " + std::to_string(0.1 * (k / 50)) + " -1\n";
    }
    return Write("far.xyz", text + "2 2 3000000\n");
  }
  void ExpectInputError(const std::function<void()>& action) const {
    try {
      action();
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), Path("far.xyz"));
      EXPECT_THAT(error.what(), HasSubstr("extent is too large"));
    }
  }
};

TEST_F(FarPoints, OfAScanAreTheFilesError) {
  Site site;
  site.robots.emplace_back();
  site.robots[0].name = "cart";
  site.robots[0].scans = {CloudFile()};
  ExpectInputError([&] { PrepareScan(site, 0, 0, {}); });
}

TEST_F(FarPoints, OfADroneMapAreTheFilesError) {
  Site site;
  site.maps.emplace_back();
  site.maps[0].name = "uav";
  site.maps[0].cloud = CloudFile();
  std::vector<std::string> warnings;
  ExpectInputError([&] { PrepareMap(site, 0, 2, &warnings); });
}

}  // namespace
}  // namespace planegraph
