#include "planegraph/pipeline/pairing.h"

#include <algorithm>
#include <set>
#include <utility>

#include "pipeline/lap.h"
#include "pipeline/registering.h"
#include "planegraph/base/parallel.h"

namespace planegraph {
namespace {

constexpr double kCandidateGate = 0.5;     // metres: how far off the chained poses may be
constexpr double kCandidateSupport = 0.2;  // share of the surfaces that must be common

struct Candidate {
  std::size_t target, source;
  double support;
};

std::vector<Candidate> FindCandidates(const std::vector<ScanModel>& models,
                                      const std::vector<Rigid3>& poses,
                                      const std::vector<int>& frames,
                                      const std::set<std::pair<std::size_t, std::size_t>>& known) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < models.size(); ++i) {
    for (std::size_t j = i + 1; j < models.size(); ++j) {
      if (frames[i] != frames[j] || known.count({i, j})) continue;
      const Rigid3 guess = poses[i].Inverse() * poses[j];
      const double support = MeasureSupport(models[i], models[j], guess, kCandidateGate).agree;
      if (support >= kCandidateSupport) candidates.push_back({i, j, support});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.support > b.support; });
  return candidates;
}

}  // namespace

std::vector<PairRecord> RegisterNeighbours(const std::vector<ScanModel>& models,
                                           const std::vector<Rigid3>& world_from_scan,
                                           const std::vector<int>& frames,
                                           const std::vector<PairRecord>& known,
                                           const RegistrationOptions& options,
                                           std::size_t most_per_scan, int threads) {
  std::set<std::pair<std::size_t, std::size_t>> done;
  for (const auto& pair : known) done.insert({pair.target, pair.source});
  std::vector<std::size_t> count(models.size(), 0);
  std::vector<PairRecord> pairs;
  for (const Candidate& c : FindCandidates(models, world_from_scan, frames, done)) {
    if (count[c.target] >= most_per_scan && count[c.source] >= most_per_scan) continue;
    ++count[c.target], ++count[c.source];
    pairs.push_back({c.target, c.source, {}, false, 0.0});
  }
  ParallelFor(pairs.size(), threads, [&](std::size_t k) {
    PairRecord& pair = pairs[k];
    const Lap lap(&pair.seconds);
    const Rigid3 guess = world_from_scan[pair.target].Inverse() * world_from_scan[pair.source];
    pair.registration =
        RegisterFromGuess(models[pair.target], models[pair.source], WeakPrior(guess), options);
    pair.used = Usable(pair.registration);
  });
  return pairs;
}

}  // namespace planegraph
