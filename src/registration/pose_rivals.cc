#include "registration/pose_rivals.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planegraph/registration/map_refinement.h"
#include "registration/map_word.h"

namespace planegraph {
namespace {

constexpr std::size_t kRivalSamples = 256;  // of each scan
constexpr double kRight = 0.9;
const double kNine = std::log(kRight / (1.0 - kRight));
constexpr double kFlat = 0.7;
constexpr int kShifts = 4;  // tried either way within the slack

bool InOnePlane(const GroupSample& wall, const GroupSample& other, double gate) {
  return wall.normal.dot(other.normal) >= kSameFacing &&
         std::abs(wall.normal.dot(other.mean - wall.mean)) <= gate;
}

}  // namespace

PoseRivals::PoseRivals(const MapModel& map, const ScanGroup& group, const Sim3& found, double gate,
                       double sigma)
    : map_(map),
      pose_(found),
      gate_(gate),
      sigma_(sigma),
      samples_(SamplesOf(group, kRivalSamples)) {
  FindBlocks();
  FindWalls();
  found_ = Ask(found, Eigen::Vector3d::Zero());
}

void PoseRivals::FindBlocks() {
  std::vector<std::uint64_t> keys;
  for (const GroupSample& s : samples_) keys.push_back(MapBlock(s.mean, s.normal));
  std::vector<std::uint64_t> sorted = keys;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  blocks_ = sorted.size();
  for (const std::uint64_t key : keys) {
    block_.push_back(static_cast<std::size_t>(std::lower_bound(sorted.begin(), sorted.end(), key) -
                                              sorted.begin()));
  }
}

// Every steep surface is in the plane of one of those that stand for a wall, and may be in more.
// Where nobody knows which way is up all are steep.
void PoseRivals::FindWalls() {
  const Eigen::Vector3d up = pose_.rotation.conjugate() * map_.sky().up();
  std::vector<bool> seen(samples_.size(), false);
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    if (seen[k] || std::abs(up.dot(samples_[k].normal)) > kFlat) continue;
    std::vector<std::size_t> wall;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (InOnePlane(samples_[k], samples_[i], gate_)) wall.push_back(i), seen[i] = true;
    }
    std::stable_sort(wall.begin(), wall.end(),
                     [&](std::size_t a, std::size_t b) { return block_[a] < block_[b]; });
    walls_.push_back(std::move(wall));
  }
}

// Log of the density of a height at the right pose over the even one of the gate.
double PoseRivals::HeightRatio(double height) const {
  const double z = height / sigma_;
  const double normal =
      2.0 * gate_ / (std::sqrt(2.0 * std::numbers::pi) * sigma_) * std::exp(-0.5 * z * z);
  return std::log(kRight * normal + 1.0 - kRight);
}

std::vector<PoseRivals::Answer> PoseRivals::Ask(const Sim3& map_from_group,
                                                const Eigen::Vector3d& along) const {
  const Eigen::Matrix3d rotation = map_from_group.rotation.toRotationMatrix();
  std::vector<Answer> answers;
  for (const GroupSample& s : samples_) {
    const Eigen::Vector3d place = map_from_group * s.mean, normal = rotation * s.normal;
    const int found = map_.surfaces().Find(place, normal, gate_, kSameFacing);
    const MapWord word = WordOf(map_, found, place, normal);
    Answer answer{0.0, 0.0, 0.0, word == MapWord::kConfirmed, word == MapWord::kSilent};
    if (answer.confirmed) {
      const Surfel& surface = map_.surfaces().surfels()[found];
      answer.height = surface.normal.dot(place - surface.mean);
      answer.slope = surface.normal.dot(along);
      answer.nats = kNine + HeightRatio(answer.height);
    } else if (map_.sky().known() && !answer.open) {
      // Where the map does not know of free air a miss says nothing.
      answer.nats = -kNine;
    }
    answers.push_back(answer);
  }
  return answers;
}

PoseOdds PoseRivals::Odds(const std::vector<Divider>& dividers) const {
  std::vector<double> weights(blocks_, 0.0);
  Sums all;
  for (std::size_t i = 0; i < dividers.size(); ++i) {
    all.nats += dividers[i].nats;
    all.weight += dividers[i].weight;
    weights[block_[i]] += dividers[i].weight;
  }
  for (const double w : weights) all.squares += w * w;
  PoseOdds odds{all.Lead(), all.Lead()};
  for (const auto& wall : walls_) {
    odds.lead = std::min(odds.lead, kNine + Without(wall, dividers, weights, all).Lead());
  }
  return odds;
}

PoseRivals::Sums PoseRivals::Without(const std::vector<std::size_t>& wall,
                                     const std::vector<Divider>& dividers,
                                     const std::vector<double>& weights, Sums rest) const {
  for (std::size_t k = 0; k < wall.size();) {
    const std::size_t block = block_[wall[k]];
    double taken = 0.0;
    for (; k < wall.size() && block_[wall[k]] == block; ++k) {
      rest.nats -= dividers[wall[k]].nats;
      taken += dividers[wall[k]].weight;
    }
    rest.weight -= taken;
    rest.squares += taken * (taken - 2.0 * weights[block]);
  }
  return rest;
}

PoseOdds PoseRivals::Compare(const Eigen::Vector3d& offset, double slack) const {
  Sim3 other = pose_;
  other.translation += offset;
  const std::vector<Answer> answers = Ask(other, offset.normalized());
  std::vector<std::size_t> apart;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Answer &a = found_[i], &b = answers[i];
    if (a.confirmed != b.confirmed || a.open != b.open) apart.push_back(i);
  }
  std::vector<Divider> dividers(samples_.size());
  PoseOdds least{INFINITY, INFINITY};
  for (int shift = -kShifts; shift <= kShifts; ++shift) {
    const double metres = slack * shift / kShifts;
    for (const std::size_t i : apart) {
      const Answer& b = answers[i];
      const double nats = b.confirmed ? kNine + HeightRatio(b.height + metres * b.slope) : b.nats;
      dividers[i] = {samples_[i].weight * (found_[i].nats - nats), samples_[i].weight};
    }
    const PoseOdds odds = Odds(dividers);
    least = {std::min(least.all, odds.all), std::min(least.lead, odds.lead)};
  }
  return least;
}

}  // namespace planegraph
