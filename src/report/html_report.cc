#include "planegraph/report/html_report.h"

#include <filesystem>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "report/html.h"
#include "report/plan_svg.h"
#include "report/render.h"
#include "report/sections.h"
#include "report/style.h"
#include "report/viewer_html.h"

namespace planegraph {
namespace {

Json ReadReport(const std::string& path) {
  const std::string text = ReadTextFile(path);
  try {
    Json report = Json::parse(text);
    if (!report.is_object()) throw InputError::InFile(path, "is not a JSON object");
    return report;
  } catch (const Json::parse_error& error) {
    throw InputError::AtByte(path, error.byte, "is not valid JSON");
  } catch (const Json::exception& error) {
    throw InputError::InFile(path, std::string("cannot be used: ") + error.what());
  }
}

MergedMap ReadMap(const std::string& path) {
  constexpr std::size_t kEnough = 8000000;  // of each source: some ten for each pixel of a picture
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return {};
  return ReadMapPly(path, kEnough);
}

std::string Head(const std::string& name) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         Escape(name.empty() ? "Planegraph report" : name + " – Planegraph report") +
         "</title>\n<style>" + kReportStyle + "</style>\n</head>\n<body>\n";
}

std::string Footer(const Json& report) {
  return "<footer><p>Written by Planegraph " +
         TextOrDash(TextAt(report, {"planegraph", "version"})) + " (" +
         TextOrDash(TextAt(report, {"planegraph", "commit"})) +
         "). The same figures are in report.json. Metres, right-handed, z up.</p></footer>\n";
}

}  // namespace

std::string RenderReport(const Json& report, const MergedMap& map, const ViewerInput& viewer) {
  const ReportData data = ReadReportData(report);
  const bool is_east_north = NumberAt(report, {"origin", "lat"}).has_value();
  const PlanFrame frame(ChooseView(map.laser, data.Positions(), is_east_north));
  return Head(TextAt(report, {"name"})) + HeaderHtml(data) + "<main>\n" +
         Section("Plan", FloorPlanHtml(data, map, frame)) +
         Section("3-D view", ViewerHtml(data, viewer)) + OpenDirectionsHtml(data) + MapsHtml(data) +
         EvaluationHtml(data) + ConsistencyHtml(data) + ScansHtml(data) +
         Section("Registrations", GraphHtml(data, frame) + RegistrationsHtml(data)) +
         SwitchedOffHtml(data) + TimesHtml(data) + "<div class=\"pair\">\n" + SolveHtml(data) +
         ConfigurationHtml(data) + "</div>\n" + "</main>\n" + Footer(report) +
         ViewerScriptsHtml(data, viewer) + "</body>\n</html>\n";
}

void WriteHtmlReport(const std::string& folder) {
  const Json report = ReadReport(folder + "/report.json");
  const MergedMap map = ReadMap(folder + "/map.ply");
  const ViewerInput viewer = ReadViewerInput(folder, ReadReportData(report));
  WriteTextFile(folder + "/report.html", RenderReport(report, map, viewer));
}

}  // namespace planegraph
