#include "registration/georeference_pairs.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <unordered_map>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

std::string BaseName(const std::string& path) { return path.substr(path.find_last_of("/\\") + 1); }

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// Forms of a name, from the exact one to one without folders, case and ending.
constexpr int kNameForms = 4;
std::string NameForm(const std::string& name, int form) {
  if (form == 0) return name;
  if (form == 1) return BaseName(name);
  const std::string lower = Lower(BaseName(name));
  return form == 2 ? lower : lower.substr(0, lower.find_last_of('.'));
}

// Finds names in a list, exactly or in the first looser form that is the name of one entry alone.
class NameIndex {
 public:
  explicit NameIndex(const std::vector<std::string>& names) {
    for (int form = 0; form < kNameForms; ++form) {
      for (std::size_t i = 0; i < names.size(); ++i) {
        const auto [entry, is_new] = index_[form].emplace(NameForm(names[i], form), i);
        if (!is_new) entry->second = kAmbiguous;
      }
    }
  }
  std::optional<std::size_t> Find(const std::string& name) const {
    for (int form = 0; form < kNameForms && !name.empty(); ++form) {
      const auto entry = index_[form].find(NameForm(name, form));
      if (entry != index_[form].end() && entry->second != kAmbiguous) return entry->second;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kAmbiguous = static_cast<std::size_t>(-1);
  std::unordered_map<std::string, std::size_t> index_[kNameForms];
};

bool Earlier(const PositionPair& a, const PositionPair& b) {
  return a.time != b.time ? a.time < b.time : a.camera < b.camera;
}

}  // namespace

CameraPairing::CameraPairing(const CameraModel& model, const GpsTrack& track,
                             const std::optional<ImageTimes>& times,
                             const GeoreferenceOptions& options)
    : model_(model), track_(track), options_(options) {
  for (const Camera& camera : model.cameras) camera_names_.push_back(camera.image);
  ReadTimes(times);
  const auto nameless = [](const std::string& name) { return name.empty(); };
  if (!by_time() && std::all_of(camera_names_.begin(), camera_names_.end(), nameless)) {
    throw UsageError(
        "positions by image need the images' names, which these cameras have not: the "
        "images' times give them, too");
  }
  AddFixes();
  if (by_time()) FindDayShift();
}

std::size_t CameraPairing::valid_cameras() const {
  return static_cast<std::size_t>(std::count_if(model_.cameras.begin(), model_.cameras.end(),
                                                [](const Camera& c) { return c.valid; }));
}

void CameraPairing::ReadTimes(const std::optional<ImageTimes>& times) {
  if (!times) {
    if (by_time()) throw UsageError("positions by time need the images' times");
    return;
  }
  if (times->times.size() != model_.cameras.size()) {
    throw InputError::InFile(times->source.empty() ? "image times" : times->source,
                             std::to_string(times->times.size()) + " images, but there are " +
                                 std::to_string(model_.cameras.size()) +
                                 " cameras: row k belongs to camera k");
  }
  camera_times_ = times->times;
  // Some programs list their cameras in an order of their own; where they have names, these count.
  const NameIndex index(times->files);
  std::vector<double> by_name;
  for (std::size_t i = 0; i < camera_names_.size(); ++i) {
    const auto row = index.Find(camera_names_[i]);
    if (row) by_name.push_back(times->times[*row]);
    if (camera_names_[i].empty() && i < times->files.size()) camera_names_[i] = times->files[i];
  }
  if (by_name.size() == camera_times_.size()) camera_times_ = by_name;
}

void CameraPairing::AddFixes() {
  if (!track_.metric) {
    origin_ = options_.origin;
    if (!origin_ && !track_.fixes.empty()) origin_ = track_.fixes.front().geodetic;
  }
  track_in_world_ = FixTrack(track_, origin_);
}

void CameraPairing::FindDayShift() {
  if (camera_times_.empty()) return;
  const auto ends = std::minmax_element(camera_times_.begin(), camera_times_.end());
  day_shift_ = track_in_world_.DayShift(*ends.first, *ends.second);
}

PositionPair CameraPairing::PairOf(std::size_t camera) const {
  PositionPair pair;
  pair.camera = camera;
  pair.in_map = model_.cameras[camera].Centre();
  return pair;
}

bool CameraPairing::Interpolate(double time, PositionPair* pair) const {
  const auto moving = track_in_world_.Interpolate(time, options_.max_gap);
  if (!moving) return false;
  pair->time = time;
  pair->in_world = moving->position;
  pair->velocity = moving->velocity;
  return true;
}

std::vector<PositionPair> CameraPairing::PairsByImage() const {
  std::vector<std::string> names;
  for (const FixTrack::Fix& fix : track_in_world_.fixes()) names.push_back(fix.image);
  const NameIndex index(names);
  std::vector<PositionPair> pairs;
  std::vector<std::pair<std::string, std::size_t>> order;
  for (std::size_t i = 0; i < model_.cameras.size(); ++i) {
    const auto fix = index.Find(camera_names_[i]);
    if (!model_.cameras[i].valid || !fix) continue;
    order.emplace_back(camera_names_[i], pairs.size());
    pairs.push_back(PairOf(i));
    pairs.back().in_world = track_in_world_.fixes()[*fix].in_world;
    pairs.back().time = track_in_world_.fixes()[*fix].time;
  }
  std::sort(order.begin(), order.end());
  for (std::size_t place = 0; place < order.size() && !has_times(); ++place) {
    pairs[order[place].second].time = static_cast<double>(place);
  }
  return pairs;
}

std::vector<PositionPair> CameraPairing::Pairs(double time_offset) const {
  std::vector<PositionPair> pairs;
  if (!by_time()) {
    pairs = PairsByImage();
  } else {
    for (std::size_t i = 0; i < model_.cameras.size(); ++i) {
      PositionPair pair = PairOf(i);
      const bool found = model_.cameras[i].valid &&
                         Interpolate(camera_times_[i] + day_shift_ + time_offset, &pair);
      if (found) pairs.push_back(pair);
    }
  }
  std::sort(pairs.begin(), pairs.end(), Earlier);
  return pairs;
}

std::vector<PositionPair> CameraPairing::NearestPairs() const {
  if (!by_time()) return Pairs(0.0);
  std::vector<PositionPair> pairs;
  for (std::size_t i = 0; i < model_.cameras.size() && !track_in_world_.fixes().empty(); ++i) {
    if (!model_.cameras[i].valid) continue;
    PositionPair pair = PairOf(i);
    pair.time = camera_times_[i] + day_shift_;
    pair.in_world = track_in_world_.Nearest(pair.time)->in_world;
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end(), Earlier);
  return pairs;
}

}  // namespace planegraph
