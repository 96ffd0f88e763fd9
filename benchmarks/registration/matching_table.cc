// matching_table DATA: CPU time of matching two scans without a guess, ours and Xiao's search, on
// the 30 largest planes of every scan of the data sets, as a Markdown table. DATA is the folder
// with the sets.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "plane_subset.h"
#include "planegraph/base/angles.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/registration/closed_form.h"
#include "planegraph/registration/xiao.h"
#include "registration/pair_sets.h"
#include "report_errors.h"
#include "thread_seconds.h"

namespace planegraph {
namespace {

constexpr std::size_t kPlanes = 30;
// The poses of the closed form are starts: they have to lie where a refinement finds the rest.
constexpr double kNearMetres = 0.5, kNearRadians = 3.0 * kDegree;

struct Times {
  std::vector<double> ratios;
  double model = 0.0, matching = 0.0, registration = 0.0, xiao = 0.0;  // seconds, of all pairs
  int near = 0, xiao_near = 0;

  void Add(const Times& other) {
    ratios.insert(ratios.end(), other.ratios.begin(), other.ratios.end());
    model += other.model, matching += other.matching, xiao += other.xiao;
    registration += other.registration, near += other.near, xiao_near += other.xiao_near;
  }
};

template <typename Body>
double Seconds(const Body& body) {
  return LeastSeconds(50, body, 0.3);
}

// The best hypothesis, the planes that it makes one, and the closed form over them.
Rigid3 MatchAndSolve(const ScanModel& target, const ScanModel& source) {
  const auto hypotheses = FindHypotheses(target, source);
  if (hypotheses.empty()) return {};
  const Rigid3& start = hypotheses[0].target_from_source;
  RefinementOptions only_pairs;
  only_pairs.most_iterations = 0;
  only_pairs.most_surfels = 400;
  std::vector<PlaneMatch> matches;
  for (const PlanePair& pair : RefinePose(target, source, start, only_pairs).correspondences) {
    matches.push_back({MakeFittedPlane(target.planes->planes[pair.target]),
                       MakeFittedPlane(source.planes->planes[pair.source])});
  }
  return matches.size() < 3 ? start : SolveClosedForm(matches).target_from_source;
}

bool Near(const Rigid3& found, const Rigid3& truth) {
  return (found.translation - truth.translation).norm() < kNearMetres &&
         AngleBetween(found.rotation, truth.rotation) < kNearRadians;
}

Times Compare(const PlaneSet& target, const PlaneSet& source, const Rigid3& truth) {
  XiaoOptions all_planes;
  all_planes.min_area = 0.0;
  const ScanModel target_model(target), source_model(source);
  Times times;
  times.model = Seconds([&] { ScanModel model(source); });
  times.matching = Seconds([&] { MatchAndSolve(target_model, source_model); });
  times.registration = Seconds([&] { Register(target_model, source_model); });
  times.xiao = Seconds([&] { RegisterXiao(target, source, all_planes); });
  times.ratios.push_back(times.xiao / times.matching);
  times.near = Near(MatchAndSolve(target_model, source_model), truth);
  times.xiao_near = Near(RegisterXiao(target, source, all_planes).target_from_source(), truth);
  return times;
}

void Print(const std::string& name, Times times) {
  std::sort(times.ratios.begin(), times.ratios.end());
  const auto n = static_cast<double>(times.ratios.size());
  const auto each = [&](double seconds) { return 1e3 * seconds / n; };
  std::printf("| %s | %.0f | %.2f | %d | %.1f | %.0f | %d | **%.0f** | %.0f, %.0f, %.0f | %.2f |\n",
              name.c_str(), n, each(times.matching), times.near, each(times.registration),
              each(times.xiao), times.xiao_near, times.xiao / times.matching, times.ratios.front(),
              times.ratios[times.ratios.size() / 2], times.ratios.back(), each(times.model));
  std::fflush(stdout);
}

int Run(const std::string& data) {
  std::puts(
      "| set | pairs | matching, closed form: ms | near | `Register`: ms | Xiao: ms | near | "
      "ratio | least, median, largest | a scan prepared: ms |\n"
      "|---|---|---|---|---|---|---|---|---|---|");
  Times all;
  for (const PairSet& set : ReadPairSets(data)) {
    std::vector<PlaneSet> planes;
    for (const PlaneSet& scan : set.planes) planes.push_back(LargestPlanes(scan, kPlanes));
    Times times;
    for (const auto& [source, target] : set.Pairs()) {
      times.Add(Compare(planes[target], planes[source], set.TargetFromSource(target, source)));
    }
    Print(set.name, times);
    all.Add(times);
  }
  Print("together", all);
  return 0;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "matching_table DATA\n"), 1;
  return planegraph::ReportErrors([&] { return planegraph::Run(argv[1]); });
}
