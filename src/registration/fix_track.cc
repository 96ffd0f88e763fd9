#include "registration/fix_track.h"

#include <algorithm>
#include <cmath>

#include "planegraph/io/local_frame.h"

namespace planegraph {
namespace {

constexpr double kDay = 86400.0;

}  // namespace

FixTrack::FixTrack(const GpsTrack& track, const std::optional<GeodeticPosition>& origin) {
  const LocalFrame frame(origin.value_or(GeodeticPosition{}));
  for (const GpsFix& fix : track.fixes) {
    const Eigen::Vector3d in_world = fix.geodetic ? frame.ToLocal(*fix.geodetic) : fix.metric;
    fixes_.push_back({fix.time, in_world, fix.image});
    has_times_ = has_times_ && std::isfinite(fix.time);
  }
  if (track.by_image) return;
  std::stable_sort(fixes_.begin(), fixes_.end(),
                   [](const Fix& a, const Fix& b) { return a.time < b.time; });
  const auto same = [](const Fix& a, const Fix& b) { return a.time == b.time; };
  fixes_.erase(std::unique(fixes_.begin(), fixes_.end(), same), fixes_.end());
}

std::optional<FixTrack::Moving> FixTrack::Interpolate(double time, double max_gap) const {
  const auto next = std::lower_bound(fixes_.begin(), fixes_.end(), time,
                                     [](const Fix& fix, double t) { return fix.time < t; });
  if (next == fixes_.end()) return {};
  const Fix& after = *next;
  const Fix& before = next == fixes_.begin() ? after : *std::prev(next);
  const double gap = after.time - before.time;
  const bool within = gap > 0.0 && gap <= max_gap;
  if (!within && after.time != time) return {};
  Moving moving;
  if (within) moving.velocity = (after.in_world - before.in_world) / gap;
  moving.position = after.in_world - (after.time - time) * moving.velocity;
  return moving;
}

const FixTrack::Fix* FixTrack::Nearest(double time) const {
  const auto nearer = [&](const Fix& a, const Fix& b) {
    return std::abs(a.time - time) < std::abs(b.time - time);
  };
  const auto found = std::min_element(fixes_.begin(), fixes_.end(), nearer);
  return found == fixes_.end() ? nullptr : &*found;
}

double FixTrack::DayShift(double first, double last) const {
  if (fixes_.empty()) return 0.0;
  const auto overlap = [&](double shift) {
    return first + shift <= fixes_.back().time && last + shift >= fixes_.front().time;
  };
  const double middle = 0.5 * (fixes_.front().time + fixes_.back().time - first - last);
  const double shift = kDay * std::round(middle / kDay);
  return !overlap(0.0) && overlap(shift) ? shift : 0.0;
}

}  // namespace planegraph
