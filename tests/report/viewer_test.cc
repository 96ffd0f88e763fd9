// What the page carries for its 3-D view, read back byte by byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "report/html_checker.h"
#include "report/render.h"
#include "report/sample_run.h"
#include "report/viewer_input.h"
#include "report/viewer_points.h"

namespace planegraph {
namespace {

using testing::HasSubstr;
using testing::Not;

MapPlyPoint PointAt(float x, float y, float z, int scan, int plane) {
  MapPlyPoint point;
  point.position = {x, y, z};
  point.rgb = {10, 20, 30};
  point.source = scan < 0 ? PointSource::kVision : PointSource::kLaser;
  point.scan = scan;
  point.plane = plane;
  return point;
}

// A drone's point, two of the first scan (one 4 mm above its plane z = 1), one of the second.
ViewerInput SmallInput(std::string_view script) {
  ViewerInput input;
  input.script = script;
  input.sample.offset = {100.0, 200.0, 0.0};
  input.sample.points = {PointAt(-100, -200, 0, -1, 3), PointAt(-98, -200, 1.004f, 0, 0),
                         PointAt(-97, -199, 2, 0, -1), PointAt(-92, -197, 5, 1, 70000)};
  input.sample.total = 40;
  ViewerPlane plane;
  plane.distance = 1.0;
  plane.area = 2.0;
  plane.rms = 0.001;
  plane.hull = {{0, 0, 1}, {2, 0, 1}, {0, 2, 1}};
  input.planes = {{plane}, {}};
  return input;
}

std::uint16_t Column(const std::string& columns, std::size_t k, std::size_t i, std::size_t count) {
  const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(columns[at]); };
  std::uint16_t sum = 0;
  for (std::size_t j = 0; j <= i; ++j) {
    sum = static_cast<std::uint16_t>(sum + byte(2 * k * count + j) +
                                     256 * byte((2 * k + 1) * count + j));
  }
  return sum;
}

TEST(ViewerPoints, HoldPositionsPlanesAndResiduals) {
  const nlohmann::json json = SampleReport();
  const ReportData data = ReadReportData(json);
  const ViewerInput input = SmallInput("x");
  const ViewerBox box = ChooseViewerBox(input.sample, data.Positions());
  const ViewerPoints points = PackViewerPoints(data, input, box);
  ASSERT_EQ(points.count, 4u);
  ASSERT_EQ(points.columns.size(), 4u * 12u);
  ASSERT_EQ(points.runs.size(), 3u);
  EXPECT_EQ(points.runs[0].scan, -1);
  EXPECT_EQ(points.runs[1].count, 2u);
  for (std::size_t i = 0; i < 4; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double step = box.extent[axis] / 65535.0;
      const double value = box.low[axis] + step * Column(points.columns, axis, i, 4);
      const double expected = input.sample.points[i].position[axis] + input.sample.offset[axis];
      EXPECT_NEAR(value, expected, 0.51 * step + 1e-5);
    }
  }
  EXPECT_EQ(Column(points.columns, 3, 0, 4), 3);
  EXPECT_EQ(Column(points.columns, 3, 2, 4), 65535);
  EXPECT_EQ(Column(points.columns, 3, 3, 4), 65535) << "a number that 16 bits do not hold";
  EXPECT_EQ(points.columns[8 * 4], 10);
  const auto residual = static_cast<signed char>(points.columns[11 * 4 + 1]);
  EXPECT_NEAR(residual * points.residual_step, 0.004, 1e-5);
  EXPECT_EQ(static_cast<signed char>(points.columns[11 * 4 + 2]), -128);
}

TEST(ViewerPoints, StrayPointsDoNotWidenTheBox) {
  MapSample sample;
  for (int i = 0; i < 5000; ++i) {
    sample.points.push_back(PointAt(float(i % 100), float(i / 100), 1, 0, 0));
  }
  sample.points.push_back(PointAt(1e6f, 0, 0, 0, 0));
  const ViewerBox box = ChooseViewerBox(sample, {{0, 0, 0}});
  EXPECT_LT(box.extent.maxCoeff(), 200.0);
  EXPECT_LE(box.low.x(), 0.0);
}

TEST(ViewerHtml, TheScriptsComeLastAndCloseNothing) {
  nlohmann::json report = SampleReport();
  report["scans"][0]["id"] = "</script><b>/000";
  const std::string page = RenderReport(report, {}, SmallInput("start();"));
  EXPECT_THAT(page, HasSubstr("<div id=\"viewer\"></div>"));
  EXPECT_THAT(page, HasSubstr("<tr class=\"weak\" data-scan=\"1\">"));
  EXPECT_THAT(page, HasSubstr("data-registration=\"3\""));
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));
  EXPECT_LT(page.find("</footer>"), page.find("<script type=\"application/json\""));
  EXPECT_THAT(page, HasSubstr("start();</script>"));
}

TEST(ViewerHtml, WithoutAScriptThePageSaysSo) {
  const std::string page = RenderReport(SampleReport(), {}, SmallInput(""));
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, HasSubstr("no 3-D view: the program that wrote it was built without Node.js"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
}

class ViewerFiles : public TestFolder {};

TEST_F(ViewerFiles, ASampleIsEvenAndTheSameInEveryRun) {
  {
    MapPlyWriter writer(Path("map.ply"), {1, 2, 3});
    for (int i = 0; i < 100000; ++i) {
      writer.Add({float(i), 0, 0}, {1, 2, 3}, PointSource::kLaser, i / 1000, i % 7);
    }
    writer.Commit();
  }
  const MapSample sample = SampleMapPly(Path("map.ply"), 1000);
  EXPECT_EQ(sample.total, 100000u);
  EXPECT_EQ(sample.offset, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(sample.points.size(), 1000u);
  for (std::size_t k = 0; k < 1000; ++k) {
    const auto i = static_cast<int>(sample.points[k].position.x());
    EXPECT_EQ(i / 100, static_cast<int>(k));
    EXPECT_EQ(sample.points[k].scan, i / 1000);
    EXPECT_EQ(sample.points[k].plane, i % 7);
  }
  EXPECT_EQ(SampleMapPly(Path("map.ply"), 1000).points[17].position, sample.points[17].position);
  EXPECT_EQ(SampleMapPly(Path("map.ply"), 1000000).points.size(), 100000u);
  EXPECT_TRUE(SampleMapPly(Path("absent.ply"), 10).points.empty());
}

}  // namespace
}  // namespace planegraph
