#include "planegraph/report/html_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "planegraph/io/cloud_writer.h"
#include "report/html_checker.h"
#include "report/png_reader.h"
#include "report/render.h"
#include "report/report_folder.h"
#include "report/sample_run.h"

namespace planegraph {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(HtmlReport, ShowsWhatTheRunSays) {
  WriteMap();
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, HasSubstr("All 3 scans joined in one component by 2 registrations;"));
  EXPECT_THAT(page, HasSubstr("nothing holds a direction of 1 scan"));
  EXPECT_THAT(page, HasSubstr("translation along (1.00, 0.00, 0.00): not observed by the planes, "
                              "sigma 0.60\u00a0m from odometry"));
  EXPECT_THAT(page, HasSubstr("rotation about (0.00, 0.00, 1.00): not observed, nothing holds it"));
  EXPECT_THAT(page, HasSubstr("1\u202f234\u202f567"));
  EXPECT_THAT(page, HasSubstr("two poses explain the planes"));
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">4.2</td>"));    // residual, mm
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">600.0</td>"));  // sigma: sqrt(0.36) m
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">∞</td>"));      // a null variance
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">12.3</td>"));   // ATE, mm
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">1.000</td>"));  // ATE rotation, deg
  EXPECT_THAT(page, HasSubstr("<li>translation along (1.00, 0.00, 0.00): not observed by planes "
                              "for 1 scan as a whole</li>"));
  EXPECT_THAT(page, HasSubstr("alignment first"));
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">0.21 to 2.41</td>"));  // band of the NEES
  EXPECT_THAT(page, HasSubstr("all poses jointly, relative to ugv/000"));
  EXPECT_THAT(page, HasSubstr("scale of uav"));
  EXPECT_THAT(page, HasSubstr("cauchy:2.4"));
  EXPECT_THAT(page, HasSubstr("huber:1"));
}

TEST_F(HtmlReport, PlotsCostsAndErrors) {
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_THAT(page, HasSubstr("aria-label=\"Cost of each iteration\""));
  EXPECT_THAT(page, HasSubstr("<title>10.25</title>"));
  EXPECT_THAT(page, HasSubstr("aria-label=\"Errors of ugv along its way\""));
  EXPECT_THAT(page, HasSubstr("<title>8.000</title>"));  // mm
}

TEST_F(HtmlReport, ShowsTheDroneMap) {
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page,
              HasSubstr("1 is anchored to the drone map uav, whose scale is 2.5000\u00a0m per "
                        "unit ± 0.20\u00a0%"));
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">2.50000 ± 0.20\u00a0%</td>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">2.45000 ± 1.1\u00a0%</td>"));  // by GPS
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">+2.04</td>"));                 // 2.5 / 2.45
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">130 / 133</td>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">2.75</td>"));  // rms of the fixes, m
  EXPECT_THAT(page, HasSubstr("latitude 51.4880000°, longitude 7.4930000°, altitude 115.00"));
  EXPECT_THAT(page, HasSubstr("not enough overlap: the map confirms 0 % of the surfaces"));
  EXPECT_THAT(page, HasSubstr("<path class=\"edge em\""));
  EXPECT_THAT(page, HasSubstr("<title>ugv/000 to uav: ok, residual 17.3 mm</title>"));
  EXPECT_THAT(page, HasSubstr("<title>uav</title>"));
  EXPECT_LT(page.find("maps 0.400 s"), page.find("placing 0.200 s"));
  EXPECT_LT(page.find("placing 0.200 s"), page.find("solve 0.250 s"));
}

TEST_F(HtmlReport, APlaceByGpsIsNoWeakness) {
  nlohmann::json report = SampleReport();
  for (auto& scan : report["scans"]) {
    scan["unobserved"] = {{{"direction", {0, 0, 1, 0, 0, 0}}, {"sigma", 0.75}, {"held_by", "gps"}}};
  }
  const std::string page = ReportOf(report.dump());
  EXPECT_THAT(page, HasSubstr("verdict good"));
  EXPECT_THAT(page, HasSubstr("known from GPS, to 0.75\u00a0m"));
  EXPECT_THAT(page, HasSubstr("sigma 0.75\u00a0m from GPS"));
}

// Of weight only where a way is known by odometry alone.
TEST_F(HtmlReport, SaysHowLongTheOdometrysMetreIsWhereItHolds) {
  nlohmann::json report = SampleReport();
  report["odometry"]["<cart>"] = {{"scale", 0.98765}, {"sigma_scale", 0.0123}};
  const char* const said = "A metre of the odometry of &lt;cart&gt; is 0.9877 ± 0.0123\u00a0m.";
  EXPECT_THAT(ReportOf(report.dump()), HasSubstr(said));
  for (auto& scan : report["scans"]) scan["unobserved"] = nlohmann::json::array();
  report["observability"]["motions"] = nlohmann::json::array();
  EXPECT_THAT(ReportOf(report.dump()), Not(HasSubstr(said)));
}

TEST_F(HtmlReport, SaysWhereADroneMapIsNotJoined) {
  nlohmann::json report = SampleReport();
  report["scans"][0]["anchored_to"] = nlohmann::json::array();
  report["maps"][0]["georeference"] = {{"status", "degenerate"}, {"reason", "a <straight> line"}};
  const std::string page = ReportOf(report.dump());
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, HasSubstr("none is anchored to the drone map uav"));
  EXPECT_THAT(page, HasSubstr("no place by GPS: a &lt;straight&gt; line; not in map.ply"));
}

TEST_F(HtmlReport, WithoutDroneMapsNothingIsSaidOfThem) {
  nlohmann::json report = SampleReport();
  report["maps"] = nlohmann::json::array();
  const std::string page = ReportOf(report.dump());
  EXPECT_THAT(page, Not(HasSubstr("rone map")));
  EXPECT_THAT(page, Not(HasSubstr("in the map")));
}

TEST_F(HtmlReport, ShowsTheDronesPointsUnderTheLasers) {
  const auto write = [&](bool drone) {
    MapPlyWriter writer(Path("map.ply"), Eigen::Vector3d::Zero());
    for (const auto& point : RoomCloud().points) {
      writer.Add(point, {90, 90, 90}, PointSource::kLaser, 0, -1);
      if (drone) writer.Add(point, {30, 120, 40}, PointSource::kVision, -1, -1);
    }
    writer.Commit();
  };
  write(true);
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_EQ(FirstFault(page), "");
  const std::size_t photo = page.find("<g class=\"photo\"><image"),
                    laser = page.find("<g class=\"map\">");
  EXPECT_NE(photo, std::string::npos);
  EXPECT_LT(photo, laser);
  EXPECT_THAT(page, HasSubstr("the drone&#39;s map from above"));
  write(false);
  EXPECT_THAT(ReportOf(SampleReport().dump()), Not(HasSubstr("<g class=\"photo\">")));
}

TEST_F(HtmlReport, EqualInputGivesEqualBytes) {
  WriteMap();
  const std::string json = SampleReport().dump();
  EXPECT_EQ(ReportOf(json), ReportOf(json));
}

TEST_F(HtmlReport, RefersToNothingOutside) {
  WriteMap();
  const std::string page = ReportOf(SampleReport().dump());
  const std::regex reference("(src|href|url)\\s*[=(]\\s*[\"']?([^\"')> ]{0,11})");
  std::size_t count = 0;
  for (std::sregex_iterator it(page.begin(), page.end(), reference), end; it != end;
       ++it, ++count) {
    const std::string target = (*it)[2];
    EXPECT_TRUE(target.starts_with("#") || target.starts_with("data:image/")) << target;
  }
  EXPECT_GT(count, 1u);
  for (const char* outside : {"http:", "https:", "@import", "<script", "<link", "//"}) {
    const std::string without_picture = std::regex_replace(page, std::regex("base64,[^\"]*"), "");
    EXPECT_THAT(without_picture, Not(HasSubstr(outside)));
  }
}

TEST_F(HtmlReport, HoldsTheMapAsAPicture) {
  WriteMap();
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_LT(page.size(), 2'000'000u);
  const std::string begin = "data:image/png;base64,";
  const std::size_t at = page.find(begin) + begin.size();
  ASSERT_NE(page.find(begin), std::string::npos);
  DecodedPng png;
  DecodePng(DecodeBase64(page.substr(at, page.find('"', at) - at)), &png);
  EXPECT_GT(png.width, 100u);
  EXPECT_GT(png.width, png.height);  // the room and the scans are wider than deep
}

TEST_F(HtmlReport, WithoutAMapStillHasThePlanOfTheScans) {
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, Not(HasSubstr("data:image")));
  EXPECT_THAT(page, HasSubstr("<ellipse"));
}

TEST_F(HtmlReport, TextOfTheUserIsEscaped) {
  nlohmann::json report = SampleReport();
  const std::string evil = "<script>alert('x')</script>\"&";
  report["name"] = evil;
  report["scans"][0]["id"] = evil + "/000";
  report["registrations"][1]["reason"] = evil;
  report["registrations"][1]["target"] = evil + "/000";
  report["registrations"][1]["status"] = evil;
  report["warnings"] = {evil};
  report["evaluation"][evil] = report["evaluation"]["ugv"];
  report["stage_seconds"][evil] = 0.1;
  report["planegraph"]["command"] = evil;
  report["planegraph"]["flags"][evil] = evil;
  report["configuration"] = {{evil, {{evil, {evil, nullptr}}}}};
  const std::string page = ReportOf(report.dump());
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&quot;&amp;"));
}

// Every value in turn missing, null, and of another type.
void CollectPaths(const nlohmann::json& json, const nlohmann::json::json_pointer& at,
                  std::vector<nlohmann::json::json_pointer>* paths) {
  paths->push_back(at);
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) CollectPaths(value, at / key, paths);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) CollectPaths(json[i], at / i, paths);
  }
}

TEST_F(HtmlReport, AnyValueMayBeMissingNullOrOdd) {
  const nlohmann::json whole = SampleReport();
  std::vector<nlohmann::json::json_pointer> paths;
  CollectPaths(whole, nlohmann::json::json_pointer(), &paths);
  ASSERT_GT(paths.size(), 150u);
  for (const auto& path : paths) {
    if (path.empty()) continue;
    const std::vector<nlohmann::json> odd = {nullptr,    "text", -1e308, nlohmann::json::array(),
                                             {{"a", 1}}, true};
    for (const nlohmann::json& value : odd) {
      nlohmann::json report = whole;
      report[path] = value;
      ASSERT_EQ(FirstFault(RenderReport(report, {})), "") << path << " " << value;
    }
    nlohmann::json report = whole;
    if (report[path.parent_pointer()].is_object()) {
      report[path.parent_pointer()].erase(path.back());
      ASSERT_EQ(FirstFault(RenderReport(report, {})), "") << path;
    }
  }
}

TEST_F(HtmlReport, AnEmptyReportIsAReport) {
  const std::string page = ReportOf("{}");
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, HasSubstr("The report lists no scans."));
}

TEST_F(HtmlReport, SaysWhatFailed) {
  nlohmann::json report = SampleReport();
  report["components"] = 2;
  report["scans"][2]["component"] = 1;
  report["solve"]["converged"] = false;
  const std::string page = ReportOf(report.dump());
  EXPECT_THAT(page, HasSubstr("verdict bad"));
  EXPECT_THAT(page, HasSubstr("The 3 scans do not form one component but 2 (of 2, 1 scans): "
                              "cart/000 stands apart;"));
  EXPECT_THAT(page, HasSubstr("the solve did not converge"));
  report["solve"]["optimizer"] = "none";  // there was none
  EXPECT_THAT(ReportOf(report.dump()), Not(HasSubstr("the solve did not converge")));
}

TEST_F(HtmlReport, LongTablesFoldUp) {
  nlohmann::json report = SampleReport();
  const std::string few = ReportOf(report.dump());
  EXPECT_THAT(few, Not(HasSubstr("Table of all")));
  for (int i = 0; i < 20; ++i) report["registrations"].push_back(report["registrations"][0]);
  EXPECT_THAT(ReportOf(report.dump()), HasSubstr("<summary>Table of all 24 registrations"));
}

TEST_F(HtmlReport, BadFilesAreNamed) {
  EXPECT_THROW(WriteHtmlReport(Path("")), InputError);
  for (const char* text : {"", "{\"scans\": [", "[1, 2]", "nonsense"}) {
    Write("report.json", text);
    try {
      WriteHtmlReport(Path(""));
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.file(), HasSubstr("report.json"));
    }
  }
  Write("report.json", "{\"a\": }");
  try {
    WriteHtmlReport(Path(""));
  } catch (const InputError& error) {
    EXPECT_EQ(error.place(), "byte 7");
  }
  EXPECT_FALSE(std::filesystem::exists(Path("report.html")));
}

TEST_F(HtmlReport, ABadMapIsNamed) {
  Write("report.json", "{}");
  Write("map.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  try {
    WriteHtmlReport(Path(""));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.file(), HasSubstr("map.ply"));
  }
}

}  // namespace
}  // namespace planegraph
