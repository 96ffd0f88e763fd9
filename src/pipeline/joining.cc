#include "planegraph/pipeline/joining.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <set>

#include "planegraph/base/parallel.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr std::size_t kMostTried = 384;  // pairs of scans for each pair of frames
constexpr std::size_t kBatch = 16;
constexpr std::size_t kLeast = 3;                         // registrations that agree
constexpr double kSameMetres = 0.5, kSameRadians = 0.05;  // chained poses are this good

struct Pair {
  std::size_t target, source;
};

// All pairs of the two frames in an order that jumps about in both of them: where the ways meet is
// not known.
std::vector<Pair> PairsOf(const std::vector<std::size_t>& targets,
                          const std::vector<std::size_t>& sources) {
  std::vector<Pair> pairs;
  const std::size_t count = targets.size() * sources.size();
  constexpr double kGolden = 0.6180339887498949;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < count; ++k) {
    order.push_back({std::fmod(kGolden * static_cast<double>(k + 1), 1.0), k});
  }
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < std::min(count, kMostTried); ++k) {
    const std::size_t at = order[k].second;
    pairs.push_back({targets[at / sources.size()], sources[at % sources.size()]});
  }
  return pairs;
}

std::vector<std::size_t> Members(const std::vector<int>& frames, int wanted) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i] == wanted) members.push_back(i);
  }
  return members;
}

// Whether registrations that agree are more than one: a scan that is laid wrongly onto a place is
// laid so onto all scans that see the place.
bool Independent(const std::vector<PairRecord>& agreeing) {
  std::set<std::size_t> targets, sources;
  for (const PairRecord& pair : agreeing) {
    targets.insert(pair.target);
    sources.insert(pair.source);
  }
  return agreeing.size() >= kLeast && targets.size() >= 2 && sources.size() >= 2;
}

class Joiner {
 public:
  Joiner(const std::vector<ScanModel>& models, const RegistrationOptions& options, int threads,
         const std::vector<Rigid3>& poses)
      : models_(models), options_(options), threads_(threads), poses_(poses) {}

  // The registrations between the frames that agree, most of all; empty: nothing to rely on.
  std::vector<PairRecord> Find(const std::vector<std::size_t>& targets,
                               const std::vector<std::size_t>& sources) const;
  // One frame from the other by a registration of two of their scans.
  Rigid3 Motion(const PairRecord& pair) const {
    return poses_[pair.target] * pair.registration.target_from_source() *
           poses_[pair.source].Inverse();
  }

 private:
  std::vector<PairRecord> RegisterAll(const std::vector<Pair>& pairs, std::size_t first) const;
  bool Agree(const PairRecord& a, const PairRecord& b) const;
  std::vector<PairRecord> LargestAgreement(const std::vector<PairRecord>& found) const;

  const std::vector<ScanModel>& models_;
  const RegistrationOptions& options_;
  int threads_;
  const std::vector<Rigid3>& poses_;
};

std::vector<PairRecord> Joiner::RegisterAll(const std::vector<Pair>& pairs,
                                            std::size_t first) const {
  std::vector<PairRecord> records(std::min(kBatch, pairs.size() - first));
  ParallelFor(records.size(), threads_, [&](std::size_t k) {
    const auto start = std::chrono::steady_clock::now();
    const auto& [target, source] = pairs[first + k];
    records[k] = {target, source, Register(models_[target], models_[source], options_)};
    records[k].seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  });
  std::erase_if(records, [](const PairRecord& r) {
    return r.registration.status != RegistrationStatus::kOk;
  });
  return records;
}

// Whether both say the same of where the sources stand: chained poses lever a small turn far away.
bool Joiner::Agree(const PairRecord& a, const PairRecord& b) const {
  const Rigid3 one = Motion(a), other = Motion(b);
  const Eigen::Vector3d& place = poses_[a.source].translation;
  return (one * place - other * place).norm() < kSameMetres &&
         AngleBetween(one.rotation, other.rotation) < kSameRadians;
}

std::vector<PairRecord> Joiner::LargestAgreement(const std::vector<PairRecord>& found) const {
  std::vector<PairRecord> best;
  for (const PairRecord& seed : found) {
    std::vector<PairRecord> agreeing;
    for (const PairRecord& other : found) {
      if (Agree(seed, other)) agreeing.push_back(other);
    }
    if (agreeing.size() > best.size()) best = std::move(agreeing);
  }
  return best;
}

std::vector<PairRecord> Joiner::Find(const std::vector<std::size_t>& targets,
                                     const std::vector<std::size_t>& sources) const {
  const std::vector<Pair> pairs = PairsOf(targets, sources);
  std::vector<PairRecord> found, agreeing;
  for (std::size_t first = 0; first < pairs.size(); first += kBatch) {
    for (auto& record : RegisterAll(pairs, first)) found.push_back(std::move(record));
    agreeing = LargestAgreement(found);
    if (Independent(agreeing) && 2 * agreeing.size() > found.size()) break;
  }
  if (!Independent(agreeing) || 2 * agreeing.size() <= found.size()) return {};
  for (PairRecord& record : agreeing) record.used = true;
  return agreeing;
}

}  // namespace

std::vector<PairRecord> JoinFrames(const std::vector<ScanModel>& models,
                                   const RegistrationOptions& options, int threads,
                                   std::vector<Rigid3>* world_from_scan, std::vector<int>* frames) {
  std::vector<PairRecord> joined;
  for (bool again = true; again;) {
    again = false;
    const std::set<int> all(frames->begin(), frames->end());
    for (auto target = all.begin(); target != all.end() && !again; ++target) {
      for (auto source = std::next(target); source != all.end() && !again; ++source) {
        const auto sources = Members(*frames, *source);
        const Joiner joiner(models, options, threads, *world_from_scan);
        const auto found = joiner.Find(Members(*frames, *target), sources);
        if (found.empty()) continue;
        const Rigid3 motion = joiner.Motion(found.front());
        for (const std::size_t i : sources) {
          (*world_from_scan)[i] = motion * (*world_from_scan)[i];
          (*frames)[i] = *target;
        }
        joined.insert(joined.end(), found.begin(), found.end());
        again = true;
      }
    }
  }
  return joined;
}

}  // namespace planegraph
