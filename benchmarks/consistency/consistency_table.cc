// consistency_table FOLDER [FOLDER...]: the table of docs/observability.md on how honest the
// covariances are. Of each folder, named like a row of the table, it reads every report.json below
// and joins what their `reference.consistency` says.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "planegraph/base/chi_square.h"
#include "planegraph/base/median.h"
#include "report_errors.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

constexpr std::array<double, 3> kLevels = {0.5, 0.9, 0.95};

struct Site {
  double nees = 0.0;
  int degrees = 0;
};

struct Row {
  std::vector<Site> sites;
  std::vector<double> poses, scales;  // squared errors in units of their covariance
};

void Add(const Json& consistency, Row* row) {
  if (consistency.contains("pose_nees")) {
    row->sites.push_back({consistency.at("pose_nees"), consistency.at("degrees_of_freedom")});
    for (const auto& [name, robot] : consistency.at("robots").items()) {
      for (const Json& each : robot.at("each")) row->poses.push_back(6.0 * each.get<double>());
    }
  }
  if (consistency.contains("scale_nees")) row->scales.push_back(consistency.at("scale_nees"));
}

Row ReadRow(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().filename() == "report.json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  Row row;
  for (const auto& file : files) {
    Add(Json::parse(std::ifstream(file)).at("reference").at("consistency"), &row);
  }
  return row;
}

std::string Coverage(const std::vector<double>& squares, int degrees) {
  std::string text;
  for (const double level : kLevels) {
    const double limit = ChiSquareQuantile(level, degrees);
    const auto inside = std::count_if(squares.begin(), squares.end(),
                                      [&](double square) { return square <= limit; });
    char share[32];
    std::snprintf(share, sizeof share, "%s%.0f", text.empty() ? "" : " / ",
                  100.0 * static_cast<double>(inside) / static_cast<double>(squares.size()));
    text += share;
  }
  return text;
}

void Print(const std::string& name, const Row& row) {
  if (row.sites.empty()) return;
  double sum = 0.0;
  int degrees = 0, inside = 0;
  std::vector<double> all;
  for (const Site& site : row.sites) {
    sum += site.nees;
    degrees += site.degrees;
    all.push_back(site.nees);
    const double chi2 = site.nees * site.degrees;
    inside += chi2 >= ChiSquareQuantile(0.025, site.degrees) &&
              chi2 <= ChiSquareQuantile(0.975, site.degrees);
  }
  const double count = static_cast<double>(row.sites.size());
  std::printf("| %s | %zu | %s | %.2f (%.2f) | %.2f to %.2f | %d of %zu |\n", name.c_str(),
              row.sites.size(), Coverage(row.poses, 6).c_str(), sum / count, Median(all),
              ChiSquareQuantile(0.025, degrees) / degrees,
              ChiSquareQuantile(0.975, degrees) / degrees, inside, row.sites.size());
}

void PrintScales(const Row& row) {
  if (row.scales.empty()) return;
  const int count = static_cast<int>(row.scales.size());
  double sum = 0.0;
  for (const double square : row.scales) sum += square;
  std::printf("| scale of the drone's map | %d | %s | %.2f (%.2f) | %.2f to %.2f | – |\n", count,
              Coverage(row.scales, 1).c_str(), sum / count, Median(row.scales),
              ChiSquareQuantile(0.025, count) / count, ChiSquareQuantile(0.975, count) / count);
}

int Run(int count, char** folders) {
  std::printf(
      "| data | sites | coverage of 50 / 90 / 95 %%, in %% | mean NEES (median) | 95 %% band of "
      "the "
      "mean | in band |\n|---|---|---|---|---|---|\n");
  Row all;
  for (int k = 0; k < count; ++k) {
    const Row row = ReadRow(folders[k]);
    Print(std::filesystem::path(folders[k]).filename().string(), row);
    all.sites.insert(all.sites.end(), row.sites.begin(), row.sites.end());
    all.poses.insert(all.poses.end(), row.poses.begin(), row.poses.end());
    all.scales.insert(all.scales.end(), row.scales.begin(), row.scales.end());
  }
  if (count > 1) Print("all", all);
  PrintScales(all);
  return all.sites.empty() ? 2 : 0;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: consistency_table FOLDER...\n");
    return 1;
  }
  return planegraph::ReportErrors([&] { return planegraph::Run(argc - 1, argv + 1); });
}
