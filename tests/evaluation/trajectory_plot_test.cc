#include "planegraph/evaluation/trajectory_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace planegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TrajectoryPlot SmallPlot() {
  TrajectoryPlot plot;
  plot.reference = {{0, 0, 0}, {10, 0.1, 5}, {20, 0.2, 10}};
  plot.times = {100, 101, 102};
  plot.ate_title = "ATE, alignment se3";
  plot.rpe_title = "RPE over 1 frames";
  plot.series = {{"it's_mine.tum", plot.reference, {0.01, 0.02, 0.01}, {101, 102}, {3, 4}, {1, 2}}};
  return plot;
}

TEST(GnuplotScript, NamesWhatItShows) {
  const std::string script = GnuplotScript(SmallPlot(), "svg");
  EXPECT_THAT(script, HasSubstr("set terminal svg"));
  EXPECT_THAT(script, HasSubstr("'it''s_mine.tum'"));
  EXPECT_THAT(script, HasSubstr("'ATE, alignment se3'"));
  EXPECT_THAT(script, HasSubstr("'time [s]'"));
  EXPECT_THAT(script, HasSubstr("'ATE [mm]'"));  // 2 cm at most
  EXPECT_THAT(script, HasSubstr("'RPE [m]'"));
  EXPECT_THAT(script, HasSubstr("'RPE [deg]'"));
  // Seen along y, in which the way spreads least.
  EXPECT_THAT(script, HasSubstr("'x [m]'"));
  EXPECT_THAT(script, HasSubstr("'z [m]'"));
  EXPECT_THAT(GnuplotScript(SmallPlot(), "pdf"), HasSubstr("set terminal pdfcairo"));
}

TEST(GnuplotScript, LeavesOutWhatHasNoResult) {
  TrajectoryPlot plot = SmallPlot();
  plot.has_times = false;
  plot.series[0].rpe.clear();
  plot.series[0].rpe_rotation.clear();
  plot.series[0].rpe_times.clear();
  const std::string script = GnuplotScript(plot, "svg");
  EXPECT_THAT(script, Not(HasSubstr("RPE")));
  EXPECT_THAT(script, Not(HasSubstr("time [s]")));
}

}  // namespace
}  // namespace planegraph
