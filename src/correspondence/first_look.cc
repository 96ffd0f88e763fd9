#include "correspondence/first_look.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "planegraph/geometry/cube_side.h"

namespace planegraph {

void FirstLook::Look(std::size_t rotation, const Eigen::Matrix3d& target_from_source,
                     const std::vector<Eigen::Vector3d>& translations) {
  Turn(target_from_source);
  for (const Eigen::Vector3d& t : translations) {
    all_.push_back({all_.size(), rotation, t, Score(t)});
    Remember(all_.back().score);
  }
}

std::vector<FirstLook::Candidate> FirstLook::TakeRanked() {
  std::sort(all_.begin(), all_.end(), [](const auto& a, const auto& b) {
    return std::tie(b.score, a.place) < std::tie(a.score, b.place);
  });
  return std::move(all_);
}

void FirstLook::Turn(const Eigen::Matrix3d& rotation) {
  samples_.clear();
  for (std::size_t k = 0; k < source_.samples.size(); k += kStride) {
    const Surfel& surfel = source_.map.surfels()[source_.samples[k]];
    const Eigen::Vector3d normal = rotation * surfel.normal;
    samples_.push_back(
        {rotation * surfel.mean, normal, CubeSide(normal), source_.sample_weights[k]});
  }
}

// What cannot come among the best is left early, mostly before any surface is looked for: a wrong
// pose leads most samples into empty space.
double FirstLook::Score(const Eigen::Vector3d& translation) {
  double score = 0.0, rest = Split(translation);
  for (std::size_t k = samples_.size(); k > open_ && score + rest >= least_; --k) {
    const Sample& s = samples_[order_[k - 1]];
    score -= IsFree(s.mean + translation) ? s.weight : 0.0;
  }
  for (std::size_t k = 0; k < open_ && score + rest >= least_; ++k) {
    const Sample& s = samples_[order_[k]];
    const Eigen::Vector3d point = s.mean + translation;
    rest -= s.weight;
    if (target_.map.Find(point, s.normal, options_.gate, kLeastCosine) >= 0) {
      score += s.weight;
    } else if (IsFree(point)) {
      score -= s.weight;
    }
  }
  return score;
}

// Puts the samples at whose places a surface may be first and returns their weight.
double FirstLook::Split(const Eigen::Vector3d& translation) {
  const SurfaceFilter& filter = target_.map.filter();
  const bool wide = options_.gate > SurfaceFilter::kGate;
  std::size_t last = samples_.size();
  double weight = 0.0;
  order_.resize(last);
  open_ = 0;
  for (std::uint32_t k = 0; k < samples_.size(); ++k) {
    const Sample& s = samples_[k];
    const bool may = wide || filter.MayLie(s.mean + translation, s.side);
    // No branches: which way they go is hard to foresee.
    weight += may ? s.weight : 0.0;
    last -= may ? 0 : 1;
    order_[may ? open_ : last] = k;
    open_ += may ? 1 : 0;
  }
  return weight;
}

bool FirstLook::IsFree(const Eigen::Vector3d& point) const {
  return target_.planes->range_image.IsFree(point, kFreeMargin);
}

void FirstLook::Remember(double score) {
  best_.push(score);
  if (best_.size() <= options_.most_verified) return;
  best_.pop();
  least_ = best_.top();
}

}  // namespace planegraph
