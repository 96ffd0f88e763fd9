// Real scans that fit in two ways a few degrees apart; skipped where the data sets are absent.
#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "planegraph/geometry/rotation.h"
#include "planegraph/io/trajectory_io.h"
#include "planegraph/pipeline/front_end.h"
#include "planegraph/registration/registration.h"

namespace planegraph {
namespace {

TEST(WeakPitch, IsNotOkWhereTwoPosesFitNearlyAlike) {
  const std::string folder = PLANEGRAPH_SHARED_DATA "/3dtk_dat";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const Site site = ReadSite(folder + "/site.yaml");
  const auto truth = ReadTrajectory(folder + "/reference_slam6d_p2pl_full.tum").poses;
  std::vector<ScanRecord> scans;
  for (std::size_t i = 0; i < 3; ++i) scans.push_back(PrepareScan(site, 0, i, {}));
  for (const auto& [target, source] : {std::pair{0, 1}, {1, 2}, {0, 2}}) {
    SCOPED_TRACE(source);
    const Registration result =
        Register(ScanModel(scans[target].planes), ScanModel(scans[source].planes));
    if (result.status != RegistrationStatus::kOk) continue;
    const Rigid3 expected = truth[target].Inverse() * truth[source];
    const Rigid3& found = result.target_from_source();
    EXPECT_LT((found.translation - expected.translation).norm(), 0.12);
    EXPECT_LT(AngleBetween(found.rotation, expected.rotation), 2.5 * std::numbers::pi / 180.0);
  }
}

}  // namespace
}  // namespace planegraph
