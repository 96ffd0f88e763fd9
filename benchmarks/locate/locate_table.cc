// locate_table SITE...: looks for every scan of the sites in their drone maps, alone, in pairs and
// by the paper's cells, and prints how many were found as Markdown (docs/localization.md). SITE is
// a site file or its folder, with truth/similarity.json beside it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "locate/outcome.h"
#include "report_errors.h"

namespace planegraph {
namespace {

// The counts of one way to look, over covered and uncovered scans.
struct Counts {
  int covered = 0, covered_right = 0, covered_wrong = 0;
  int uncovered = 0, uncovered_right = 0, uncovered_wrong = 0;
  std::vector<double> seconds;

  void Add(const std::vector<Outcome>& outcomes) {
    for (const Outcome& o : outcomes) {
      seconds.push_back(o.seconds);
      (o.covered ? covered : uncovered)++;
      if (o.right()) (o.covered ? covered_right : uncovered_right)++;
      if (o.wrong()) (o.covered ? covered_wrong : uncovered_wrong)++;
    }
  }
};

struct Results {
  LocatedSite site;
  std::vector<Outcome> alone, pairs, cells;
};

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

std::string Verdict(const Outcome& o) {
  if (o.right()) return "right";
  return o.wrong() ? "**WRONG**" : ToString(o.status);
}

void PrintCounts(const std::string& name, const char* way, const Counts& c) {
  const auto undecided = [](int all, int right, int wrong) { return all - right - wrong; };
  std::printf("| %s | %s | %d of %d | %d | %d | %d of %d | %d | %d | %.2f |\n", name.c_str(), way,
              c.covered_right, c.covered, undecided(c.covered, c.covered_right, c.covered_wrong),
              c.covered_wrong, c.uncovered_right, c.uncovered,
              undecided(c.uncovered, c.uncovered_right, c.uncovered_wrong), c.uncovered_wrong,
              Quantile(c.seconds, 0.5));
}

void PrintSummary(const std::vector<Results>& all) {
  std::puts(
      "\n### How many were found\n\n| site | looked for | covered: right | undecided | wrong | "
      "uncovered: right | undecided | wrong | CPU s, median "
      "|\n|---|---|---|---|---|---|---|---|---|");
  Counts alone, pairs, cells;
  for (const Results& r : all) {
    Counts one[3];
    one[0].Add(r.alone), one[1].Add(r.pairs), one[2].Add(r.cells);
    PrintCounts(r.site.name, "alone", one[0]);
    PrintCounts(r.site.name, "two at once", one[1]);
    PrintCounts(r.site.name, "cells (paper)", one[2]);
    alone.Add(r.alone), pairs.Add(r.pairs), cells.Add(r.cells);
  }
  if (all.size() == 1) return;
  PrintCounts("all", "alone", alone);
  PrintCounts("all", "two at once", pairs);
  PrintCounts("all", "cells (paper)", cells);
}

void PrintScan(const LocatedSite& site, const Outcome& o) {
  std::printf("| %s | %.2f | %s | %.3f | %.2f | %.2f | %.2f | %.1f | %.1f | %.1f | %.0e | %.2f |\n",
              site.scans[o.scan].id.c_str(), site.coverage[o.scan], Verdict(o).c_str(), o.metres,
              o.degrees, o.confirmed, o.contradicted, o.best, o.truth, o.wrong_pose, o.chance,
              o.seconds);
}

void PrintScans(const Results& results) {
  const auto table = [&](const char* title, const std::vector<Outcome>& outcomes) {
    std::printf(
        "\n#### %s: %s\n\n| scan | coverage | result | best pose off, m | deg | confirmed | "
        "contradicted | nats, best | truth | best wrong | chance | CPU s "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        results.site.name.c_str(), title);
    for (const Outcome& o : outcomes) PrintScan(results.site, o);
  };
  table("each scan alone", results.alone);
  table("each scan and the next", results.pairs);
}

void PrintCells(const Results& results) {
  std::printf(
      "\n#### %s: the paper's cells\n\n| scan | coverage | result | best cell off, m | deg | s |\n"
      "|---|---|---|---|---|---|\n",
      results.site.name.c_str());
  for (const Outcome& o : results.cells) {
    std::printf("| %s | %.2f | %s | %.2f | %.1f | %.2f |\n", results.site.scans[o.scan].id.c_str(),
                results.site.coverage[o.scan], Verdict(o).c_str(), o.metres, o.degrees, o.seconds);
  }
}

// What a reader would ask about first: wrong ones, and covered scans that were not found.
void PrintCases(const std::vector<Results>& all) {
  std::puts("\n### Wrong, or covered and not found (alone and two at once)\n");
  for (const Results& r : all) {
    for (const auto* outcomes : {&r.alone, &r.pairs}) {
      for (const Outcome& o : *outcomes) {
        if (!o.wrong() && (o.right() || !o.covered)) continue;
        std::printf(
            "- %s, %s%s (coverage %.2f): %s; best pose %.2f m and %.1f deg off with %.1f nats, the "
            "truth %.1f, the best wrong pose %.1f; chance %.0e, of it nowhere %.0e\n",
            r.site.name.c_str(), r.site.scans[o.scan].id.c_str(),
            o.scans > 1 ? " and the next" : "", r.site.coverage[o.scan], Verdict(o).c_str(),
            o.metres, o.degrees, o.best, o.truth, o.wrong_pose, o.chance, o.nowhere);
      }
    }
  }
}

// What the rules look at, by what the best pose is.
struct Sides {
  std::vector<double> best[2], lead[2], chance[2];  // 1: right

  void Add(const std::vector<Outcome>& outcomes) {
    for (const Outcome& o : outcomes) {
      best[o.near].push_back(o.best);
      chance[o.near].push_back(o.chance);
      if (o.near && std::isfinite(o.wrong_pose)) lead[1].push_back(o.best - o.wrong_pose);
      if (!o.near) lead[0].push_back(o.best - o.truth);
    }
  }
};

void PrintQuantiles(const char* what, const std::vector<double>& values) {
  std::printf("| %s | %zu | %.2g | %.2g | %.2g | %.2g | %.2g | %.2g |\n", what, values.size(),
              Quantile(values, 0.0), Quantile(values, 0.05), Quantile(values, 0.25),
              Quantile(values, 0.5), Quantile(values, 0.95), Quantile(values, 1.0));
}

void PrintSides(const char* title, const Sides& s) {
  std::printf(
      "\n#### %s\n\n| value | count | least | 5 %% | 25 %% | median | 95 %% | greatest |\n"
      "|---|---|---|---|---|---|---|---|\n",
      title);
  PrintQuantiles("nats of the best pose where it is right", s.best[1]);
  PrintQuantiles("nats of the best pose where it is wrong", s.best[0]);
  PrintQuantiles("its lead over the best wrong one where it is right", s.lead[1]);
  PrintQuantiles("its lead over the truth where it is wrong", s.lead[0]);
  PrintQuantiles("chance where the best pose is right", s.chance[1]);
  PrintQuantiles("chance where the best pose is wrong", s.chance[0]);
}

// What other limits of the chance would let through.
void PrintRules(const char* title, const std::vector<Outcome>& tries) {
  std::printf(
      "\n#### %s: what the limit of the chance lets through\n\n| limit | right poses | wrong poses "
      "|\n|---|---|---|\n",
      title);
  for (const double limit : {0.5, 0.1, 1e-2, 1e-3, 1e-4, 1e-6}) {
    int passed[2] = {0, 0}, all[2] = {0, 0};
    for (const Outcome& o : tries) {
      ++all[o.near];
      if (o.chance <= limit) ++passed[o.near];
    }
    std::printf("| %g | %d of %d | %d of %d |\n", limit, passed[1], all[1], passed[0], all[0]);
  }
}

void PrintSeparation(const std::vector<Results>& all) {
  std::puts("\n### How far right and wrong poses are apart");
  Sides sides[2];
  std::vector<Outcome> tries[2];
  for (const Results& r : all) {
    sides[0].Add(r.alone), sides[1].Add(r.pairs);
    tries[0].insert(tries[0].end(), r.alone.begin(), r.alone.end());
    tries[1].insert(tries[1].end(), r.pairs.begin(), r.pairs.end());
  }
  PrintSides("Alone", sides[0]);
  PrintRules("Alone", tries[0]);
  PrintSides("Two at once", sides[1]);
  PrintRules("Two at once", tries[1]);
}

void PrintHead(int argc, char** argv) {
  std::printf("Made by\n\n```sh\nlocate_table");
  for (int k = 1; k < argc; ++k) std::printf(" %s", argv[k]);
  std::printf("\n```\n");
}

int Run(int argc, char** argv) {
  constexpr int kThreads = 0;
  std::vector<Results> all;
  for (int k = 1; k < argc; ++k) {
    Results results;
    results.site = ReadLocatedSite(argv[k], kThreads);
    results.alone = LocateAlone(results.site, kThreads);
    results.pairs = LocateInPairs(results.site, kThreads);
    results.cells = LocateInCells(results.site, kThreads);
    all.push_back(std::move(results));
  }
  PrintHead(argc, argv);
  PrintSummary(all);
  PrintCases(all);
  PrintSeparation(all);
  if (all.size() == 1) std::puts("\n### Scan by scan"), PrintScans(all[0]), PrintCells(all[0]);
  const auto wrong = [](const Outcome& o) { return o.wrong(); };
  const bool good = std::all_of(all.begin(), all.end(), [&](const Results& r) {
    return std::none_of(r.alone.begin(), r.alone.end(), wrong) &&
           std::none_of(r.pairs.begin(), r.pairs.end(), wrong);
  });
  return good ? 0 : 1;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "locate_table SITE...\n"), 1;
  return planegraph::ReportErrors([&] { return planegraph::Run(argc, argv); });
}
