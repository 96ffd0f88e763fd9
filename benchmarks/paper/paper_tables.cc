// paper_tables SITE.yaml: the tables of the paper for a site, as Markdown (docs/paper_tables.md).
// Times are wall-clock seconds on one thread, the least of some runs.
#include <cstdio>
#include <string>

#include "paper/published.h"
#include "paper/runs.h"
#include "paper/section.h"
#include "paper/small_sets.h"
#include "planegraph/base/angles.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/registration/xiao.h"
#include "report_errors.h"
#include "thread_seconds.h"

namespace planegraph {
namespace {

constexpr int kRuns = 5;

void PrintScans(const MapResult& result) {
  std::puts(
      "\n## Table I: plane segmentation of the laser scans\n\n| scan | points | preprocessing, s | "
      "segmentation, s | planes | *paper: points* | *preprocessing, s* | *segmentation, s* | "
      "*planes* |\n|---|---|---|---|---|---|---|---|---|");
  for (std::size_t k = 0; k < result.scans.size(); ++k) {
    const ScanRecord& scan = result.scans[k];
    std::printf("| %s | %zu | %.4f | %.4f | %zu |", scan.id.c_str(), scan.points,
                scan.seconds_preprocess, scan.seconds_segment, scan.planes.planes.size());
    if (k >= kPublishedLaser.size()) {
      std::puts(" | | | |");
      continue;
    }
    const auto& paper = kPublishedLaser[k];
    std::printf(" *%d* | *%.4f* | *%.4f* | *%d* |\n", paper.points, paper.preprocessing,
                paper.segmentation, paper.planes);
  }
}

std::string ErrorText(const Rigid3& found, const std::optional<Rigid3>& truth) {
  if (!truth) return "";
  char text[64];
  std::snprintf(text, sizeof(text), "%.3f m, %.2f deg",
                (found.translation - truth->translation).norm(),
                AngleBetween(found.rotation, truth->rotation) / kDegree);
  return text;
}

struct XiaoRun {
  Registration registration;
  double seconds = 0.0;
};

XiaoRun RunXiao(const PlaneSet& target, const PlaneSet& source) {
  XiaoRun run;
  const double start = ThreadSeconds();
  run.registration = RegisterXiao(target, source);
  run.seconds = ThreadSeconds() - start;
  return run;
}

void PrintPair(const MapResult& result, const PairRecord& pair) {
  const ScanRecord &target = result.scans[pair.target], &source = result.scans[pair.source];
  const XiaoRun xiao = RunXiao(target.planes, source.planes);
  const auto truth = ReferenceStep(result, pair.target, pair.source);
  const Registration &ours = pair.registration, &theirs = xiao.registration;
  std::printf("| %s &rarr; %s | %.4f | %zu | %s | %s | %.4f | %zu | %s | %s |", target.id.c_str(),
              source.id.c_str(), pair.seconds, ours.refinement.correspondences.size(),
              ToString(ours.status), ErrorText(ours.target_from_source(), truth).c_str(),
              xiao.seconds, theirs.refinement.correspondences.size(), ToString(theirs.status),
              ErrorText(theirs.target_from_source(), truth).c_str());
  if (target.index >= kPublishedPairs.size()) return std::puts(" | |"), void();
  const auto& paper = kPublishedPairs[target.index];
  std::printf(" *%.4f* | *%d* |\n", paper.seconds, paper.correspondences);
}

void PrintPairs(const MapResult& result) {
  std::puts(
      "\n## Table II: registration of consecutive laser scans\n\n`Xiao` is the paper's search for "
      "correspondences (`register --matcher=xiao`) on the same planes, those of 2 m^2 and more. "
      "The "
      "error is\nthat of the pose between the two scans against the reference.\n\n| pair | s | "
      "correspondences | status | error | Xiao: s | correspondences | status | error | *paper: s* "
      "| "
      "*correspondences* |\n|---|---|---|---|---|---|---|---|---|---|---|");
  for (const PairRecord& pair : result.pairs) {
    const ScanRecord &target = result.scans[pair.target], &source = result.scans[pair.source];
    if (target.robot == source.robot && source.index == target.index + 1) PrintPair(result, pair);
  }
}

void PrintSection(const MapResult& result, std::size_t m, std::size_t scan, const Cloud& cloud) {
  const Section section = SectionAbout(result, m, scan, cloud);
  std::printf("| %s | %.0f x %.0f | %zu | %zu | %.4f | %zu |", result.scans[scan].id.c_str(),
              2.0 * section.half_edge, 2.0 * section.half_edge, section.points, section.patches,
              section.seconds_segment, section.planes);
  if (scan >= kPublishedSections.size()) return std::puts(" | | |"), void();
  const auto& paper = kPublishedSections[scan];
  std::printf(" *%d* | *%.4f* | *%d* |\n", paper.points, paper.segmentation, paper.planes);
}

void PrintSections(const MapResult& result) {
  std::puts("\n## Table III: plane segmentation of the sections of the drone map");
  for (std::size_t m = 0; m < result.maps.size(); ++m) {
    const MapRecord& map = result.maps[m];
    std::printf(
        "\nThe map `%s` is segmented once, as a whole: %zu points, %zu planes, %zu patches, %.3f "
        "s. A "
        "section is a query: as large as\nthe scan and %.0f m more on each side. Its seconds are "
        "its "
        "points' share of the whole.\n\n| about scan | metres | points | patches | segmentation, "
        "share, s | planes | *paper: points* | *segmentation, s* | *planes* "
        "|\n|---|---|---|---|---|---|---|---|---|\n",
        map.id.c_str(), map.points, map.planes.planes.size(), map.planes.patches.size(),
        map.seconds_segment, kSectionTolerance);
    const Cloud cloud = LoadMapCloud(result.site.maps[m], map.metric_from_map);
    for (std::size_t i = 0; i < result.scans.size(); ++i) PrintSection(result, m, i, cloud);
  }
}

void PrintMapPairs(const MapResult& result) {
  std::puts(
      "\n## Table IV: registration of the laser scans with the drone map\n\n| scan | s | "
      "correspondences | status | confirmed by the map | reason | *paper: s* | *correspondences* "
      "|\n|---|---|---|---|---|---|---|---|");
  for (const MapPairRecord& pair : result.map_pairs) {
    std::printf("| %s &rarr; %s | %.4f | %zu | %s | %.0f %% | %s |",
                result.scans[pair.scan].id.c_str(), result.maps[pair.map].id.c_str(), pair.seconds,
                pair.correspondences, ToString(pair.status), 100.0 * pair.evidence.agree,
                pair.reason.c_str());
    if (pair.scan >= kPublishedInMap.size()) {
      std::puts(" | |");
      continue;
    }
    const auto& paper = kPublishedInMap[pair.scan];
    std::printf(" *%.4f* | *%d* |\n", paper.seconds, paper.correspondences);
  }
}

void PrintErrors(const MapResult& result, const char* name) {
  for (std::size_t r = 0; r < result.site.robots.size(); ++r) {
    const auto errors = ErrorsOf(result, r);
    if (!errors) continue;
    const Statistics &rpe = errors->rpe.errors.translation, &ate = errors->ate.errors.translation;
    std::printf("| %s | %s | %.4f | %.4f | %.4f | %.3f | %.4f | %.4f | %.4f |\n",
                result.site.robots[r].name.c_str(), name, rpe.rmse, rpe.min, rpe.max,
                errors->rpe.errors.rotation.rmse / kDegree, ate.rmse, ate.min, ate.max);
  }
}

void PrintTrajectories(const Site& site, const MapResult& with_map) {
  std::puts(
      "\n## Table V: relative and absolute trajectory error, metres\n\nRPE over consecutive scans, "
      "ATE "
      "aligned by SE(3), against the site's reference.\n\n| robot | optimizer | RPE rmse | min | "
      "max | "
      "RPE rmse, deg | ATE rmse | min | max |\n|---|---|---|---|---|---|---|---|---|");
  const Site laser = LaserOnly(site);
  PrintErrors(MapTimed(laser, "none", 1), "`none`");
  PrintErrors(MapTimed(laser, "metascan", 1), "`metascan`");
  PrintErrors(MapTimed(laser, "graph", 1), "`graph`, no drone map");
  if (!site.maps.empty()) PrintErrors(with_map, "`graph`, with drone map");
  std::printf(
      "| *paper* | *pose tracking* | *%.4f* | *%.4f* | *%.4f* | | *%.4f* | *%.4f* | *%.4f* |\n",
      kPublishedRpe.rmse, kPublishedRpe.min, kPublishedRpe.max, kPublishedAte.rmse,
      kPublishedAte.min, kPublishedAte.max);
}

int Run(const std::string& path) {
  const Site site = ReadSite(path);
  const MapResult result = MapTimed(site, "graph", kRuns);
  PrintScans(result);
  PrintPairs(result);
  if (!result.maps.empty()) PrintSections(result), PrintMapPairs(result);
  PrintTrajectories(site, result);
  if (!result.maps.empty()) PrintSmallSets(result);
  return 0;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "paper_tables SITE.yaml\n"), 1;
  return planegraph::ReportErrors([&] { return planegraph::Run(argv[1]); });
}
