// What the report says of scans and registrations, by their tables, the plan and the verdict.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "report/html_checker.h"
#include "report/report_folder.h"

namespace planegraph {
namespace {

using testing::HasSubstr;
using testing::Not;

class HtmlTables : public HtmlReport {};

// Half a metre of sigma beside a millimetre of error is the place of the whole, and said to be.
TEST_F(HtmlTables, SaysWhatSigmasInTheWorldFrameHold) {
  nlohmann::json report = SampleReport();
  const char* const said = "how well GPS places the whole site";
  EXPECT_THAT(ReportOf(report.dump()), Not(HasSubstr(said)));  // relative to a fixed scan
  report["scans"][0]["covariance"] = report["scans"][1]["covariance"];
  EXPECT_THAT(ReportOf(report.dump()),
              HasSubstr(said + std::string(" is part of sigma; a registration by itself holds two "
                                           "scans to each other to about 3.0\u00a0mm "
                                           "(median).")));  // the one that is used
  report["registrations"][0]["used"] = false;
  EXPECT_THAT(ReportOf(report.dump()), HasSubstr(said + std::string(" is part of sigma.")));
  report["origin"] = nullptr;
  EXPECT_THAT(ReportOf(report.dump()), Not(HasSubstr(said)));  // a start holds them
}

// What the planes of a registration leave open they do not hold.
TEST_F(HtmlTables, SaysWhereOnlyAllPlanesTogetherHoldAScan) {
  nlohmann::json report = SampleReport();
  report["scans"][1]["unobserved"] = nlohmann::json::array();
  const char* const said = "held by the planes of all scans: those of its own registrations";
  const std::string held = ReportOf(report.dump());
  EXPECT_THAT(held, HasSubstr("translation along (1.00, 0.00, 0.00), held by planes</td>"));
  EXPECT_THAT(held, Not(HasSubstr(said)));
  report["registrations"][0]["status"] = "degenerate";
  const std::string page = ReportOf(report.dump());
  EXPECT_THAT(page, HasSubstr(said));
  EXPECT_THAT(page, Not(HasSubstr(", held by planes</td>")));
}

// Four scans of ugv, the third and fourth by themselves.
nlohmann::json BrokenReport() {
  nlohmann::json report = SampleReport();
  nlohmann::json scans = {report["scans"][0], report["scans"][1], report["scans"][0],
                          report["scans"][1]};
  for (int i = 0; i < 4; ++i) {
    scans[i]["id"] = "ugv/00" + std::to_string(i);
    scans[i]["component"] = i / 2;
    scans[i]["world_from_scan"]["translation"] = {2 * i, 1, 0};
  }
  report["scans"] = scans;
  report["components"] = 2;
  return report;
}

TEST_F(HtmlTables, SaysWhoStandsApartAndThatTheirPlaceMeansNothing) {
  const std::string page = ReportOf(BrokenReport().dump());
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, HasSubstr("but 2 (of 2, 2 scans): ugv/002 to 003 stand apart; their place in "
                              "plan and map means nothing"));
  EXPECT_THAT(page, HasSubstr("<th class=\"n\">component</th>"));
  EXPECT_THAT(page, HasSubstr("<td>ugv/003</td><td class=\"n\">2</td>"));
  // No sigmas of its place, the time, the map that it is anchored to.
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">–</td><td class=\"n\">–</td>"
                              "<td class=\"n\">0.060</td><td>uav</td>"
                              "<td>first of component 2: place unknown</td>"));
  EXPECT_THAT(page, HasSubstr("relative to the first scan of its component"));
  EXPECT_THAT(page, HasSubstr("scans that stand apart: their place means nothing"));
}

TEST_F(HtmlTables, TheWayIsCutBetweenComponents) {
  const auto ways = [](std::string page) {
    page.erase(page.find("Directions that"));  // plots draw lines of the same kind
    const std::regex way("<polyline points=\"[^\"]*\" class=\"way r0");
    return std::distance(std::sregex_iterator(page.begin(), page.end(), way), {});
  };
  nlohmann::json report = BrokenReport();
  EXPECT_EQ(ways(ReportOf(report.dump())), 2);
  for (auto& scan : report["scans"]) scan["component"] = 0;
  report["components"] = 1;
  const std::string whole = ReportOf(report.dump());
  EXPECT_EQ(ways(whole), 1);
  EXPECT_THAT(whole, Not(HasSubstr("apart\"")));
  EXPECT_THAT(whole, Not(HasSubstr("<th class=\"n\">component</th>")));
  EXPECT_THAT(whole, HasSubstr("fixed: the world's frame"));
}

// GPS of each part, or starts: then no scan is fixed.
TEST_F(HtmlTables, ScansApartThatHaveAPlaceAreNotSaidToHaveNone) {
  nlohmann::json report = BrokenReport();
  report["scans"][2]["covariance"] = report["scans"][1]["covariance"];
  const std::string page = ReportOf(report.dump());
  EXPECT_THAT(page, HasSubstr("ugv/002 to 003 stand apart"));
  EXPECT_THAT(page, Not(HasSubstr("means nothing")));
  EXPECT_THAT(page, Not(HasSubstr("place unknown")));
}

TEST_F(HtmlTables, ShowsWhatARegistrationIsWorth) {
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">345</td><td class=\"n\">4.2</td>"
                              "<td class=\"n\">1.23</td><td class=\"n\">339</td>"));
  EXPECT_THAT(page, HasSubstr("3.0\u00a0mm along (1.0,\u00a00.0,\u00a00.0)"));  // sqrt(9e-6) m
}

// At the end of a row it would stand off the screen.
TEST_F(HtmlTables, WhyARegistrationIsNotUsedStandsBelowItsRow) {
  const std::string page = ReportOf(SampleReport().dump());
  EXPECT_THAT(page, HasSubstr("<tr class=\"more unused\"><td colspan=\"13\"><div>two poses explain "
                              "the planes</div></td></tr>"));
  const std::regex more("<tr class=\"more");  // of the two that are not used
  EXPECT_EQ(std::distance(std::sregex_iterator(page.begin(), page.end(), more), {}), 2);
}

TEST_F(HtmlTables, OpenDirectionsOfARegistrationAreSaidOnce) {
  const auto count = [&](const nlohmann::json& report) {
    const std::string page = ReportOf(report.dump());
    const std::regex said("<div>[^<]*</div>"), along("translation along");
    std::ptrdiff_t most = 0;
    for (std::sregex_iterator it(page.begin(), page.end(), said), end; it != end; ++it) {
      const std::string note = it->str();
      most =
          std::max(most, std::distance(std::sregex_iterator(note.begin(), note.end(), along), end));
    }
    return most;
  };
  nlohmann::json report = SampleReport();
  auto& registration = report["registrations"][0];
  registration["unobserved"] = {{{"direction", {1, 0, 0, 0, 0, 0}}}};
  EXPECT_EQ(count(report), 1);  // beside no reason
  registration["status"] = "degenerate";
  EXPECT_EQ(count(report), 1);
  registration["reason"] = "translation along (1.00, 0.00, 0.00) is not observed";
  EXPECT_EQ(count(report), 1);
  registration["status"] = "ambiguous";
  registration["reason"] = "another pose explains nearly as much";
  EXPECT_EQ(count(report), 1);
}

TEST_F(HtmlTables, NamesWhatIsSwitchedOff) {
  nlohmann::json report = SampleReport();
  EXPECT_THAT(ReportOf(report.dump()), Not(HasSubstr("Switched off")));
  report["switched_off"] = {{{"kind", "laser-laser"},
                             {"target", "ugv/001"},
                             {"source", "cart/<7>"},
                             {"by", "consistency"},
                             {"weight", 0.0},
                             {"sigmas", 41.25},
                             {"threshold_sigmas", 6.1875},
                             {"contradicts", {"ugv/000-ugv/001"}},
                             {"reason", "it contradicts 1 other registration"}},
                            {{"kind", "robot_position"}, {"source", nullptr}}};
  const std::string page = ReportOf(report.dump());
  EXPECT_EQ(FirstFault(page), "");
  EXPECT_THAT(page, HasSubstr("Switched off"));
  EXPECT_THAT(page, HasSubstr("cart/&lt;7&gt;"));
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">41.2</td><td class=\"n\">6.2</td>"));
  EXPECT_THAT(page, HasSubstr("<div>it contradicts 1 other registration; contradicted: "
                              "ugv/000-ugv/001</div>"));
}

}  // namespace
}  // namespace planegraph
