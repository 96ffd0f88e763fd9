#include "pipeline/odometry_conventions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "planegraph/base/chi_square.h"
#include "planegraph/base/median.h"
#include "planegraph/graph/pose_error.h"
#include "planegraph/io/file_conventions.h"
#include "planegraph/pipeline/chain.h"

namespace planegraph {
namespace {

constexpr std::size_t kLeastSpeakingSteps = 3;

// One in a million of good odometry is farther off, as for contradictions.
double MostChi2() { return ChiSquareQuantile(1.0 - 1e-6, 3); }

// What was registered between two scans, and where their poses are in the odometry.
struct Step {
  std::size_t target, source;
  Rigid3 registered;
};

std::vector<Step> RegisteredSteps(std::size_t robot, const std::vector<ScanRecord>& scans,
                                  const std::vector<PairRecord>& chain) {
  std::vector<Step> steps;
  for (const PairRecord& pair : chain) {
    const ScanRecord &target = scans[pair.target], &source = scans[pair.source];
    if (target.robot != robot || source.robot != robot || !pair.used) continue;
    if (pair.registration.status != RegistrationStatus::kOk) continue;
    steps.push_back({target.index, source.index, pair.registration.target_from_source()});
  }
  return steps;
}

Rigid3 StepOf(const Trajectory& odometry, const Step& step) {
  return odometry.poses[step.target].Inverse() * odometry.poses[step.source];
}

double Chi2(const Rigid3& registered, const Rigid3& odometry, int first) {
  const Matrix6d covariance = OdometryCovariance(odometry);
  const Vector6d off = PoseError(registered, odometry);
  return off.segment<3>(first).squaredNorm() / covariance(first, first);
}

bool Agree(const Rigid3& registered, const Rigid3& odometry) {
  return Chi2(registered, odometry, 0) <= MostChi2() && Chi2(registered, odometry, 3) <= MostChi2();
}

bool WentSomewhere(const Rigid3& registered) { return Chi2(registered, {}, 0) > MostChi2(); }

std::vector<bool> Agreement(const std::vector<Step>& steps, const Trajectory& odometry) {
  std::vector<bool> agree;
  agree.reserve(steps.size());
  for (const Step& step : steps) agree.push_back(Agree(step.registered, StepOf(odometry, step)));
  return agree;
}

// ---- the ways to take an odometry ----

std::vector<FileConventions> QuaternionConventions() {
  FileConventions w_first, inverse;
  w_first.w_first = true;
  inverse.body_from_world = true;
  return {w_first, inverse};
}

// All axes but our own: those of cameras (y down, y up) first, then right-handed ones, then
// left-handed ones. A robot on a plane does not tell them all apart.
std::vector<FileConventions> AxesConventions() {
  std::vector<FileConventions> known, right, left;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) axes(row, order[row]) = (signs >> row) & 1 ? -1.0 : 1.0;
      if (axes.isIdentity(0.0)) continue;
      FileConventions conventions;
      conventions.axes = axes;
      const std::string text = AxesText(axes);
      const bool camera = text == "z,-x,-y" || text == "-z,-x,y";
      (camera ? known : axes.determinant() > 0.0 ? right : left).push_back(conventions);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  known.insert(known.end(), right.begin(), right.end());
  known.insert(known.end(), left.begin(), left.end());
  return known;
}

// Units that odometry comes in.
struct Unit {
  double metres;
  const char* name;
};
constexpr std::array<Unit, 5> kUnits = {{{0.001, "millimetres"},
                                         {0.01, "centimetres"},
                                         {0.0254, "inches"},
                                         {0.3048, "feet"},
                                         {1000.0, "kilometres"}}};

// The scale under which half of the steps are longer than registered, where it is no unit.
std::optional<double> ScaleOf(const std::vector<Step>& steps, const Trajectory& odometry) {
  std::vector<double> ratios;
  for (const Step& step : steps) {
    const double length = StepOf(odometry, step).translation.norm();
    if (length > 0.0) ratios.push_back(step.registered.translation.norm() / length);
  }
  if (ratios.empty()) return std::nullopt;
  const double scale = Median(std::move(ratios));
  return scale > 0.0 ? std::optional(scale) : std::nullopt;
}

// ---- the decision ----

struct Explanation {
  FileConventions conventions;
  std::size_t steps = 0;  // that agree
};

class Explainer {
 public:
  Explainer(std::vector<Step> steps, const Trajectory& odometry)
      : steps_(std::move(steps)), odometry_(odometry), as_read_(Agreement(steps_, odometry)) {}

  // The simplest way that explains most: one cause goes before two.
  std::optional<Explanation> Find() const;
  std::size_t AgreeAsRead() const {
    return static_cast<std::size_t>(std::count(as_read_.begin(), as_read_.end(), true));
  }
  std::size_t size() const { return steps_.size(); }

 private:
  void Try(const FileConventions& conventions, std::optional<Explanation>* best) const;
  void TryScaled(FileConventions conventions, std::optional<Explanation>* best) const;

  std::vector<Step> steps_;
  const Trajectory& odometry_;
  std::vector<bool> as_read_;
};

// Steps that agree either way say nothing; of the others most have to speak for the conventions.
void Explainer::Try(const FileConventions& conventions, std::optional<Explanation>* best) const {
  const std::vector<bool> agree = Agreement(steps_, Interpret(conventions, odometry_));
  std::size_t speaking = 0, other = 0, total = 0;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    total += agree[k] ? 1 : 0;
    if (agree[k] && as_read_[k]) continue;
    const bool speaks = agree[k] && WentSomewhere(steps_[k].registered);
    ++(speaks ? speaking : other);
  }
  if (speaking < kLeastSpeakingSteps || speaking <= other) return;
  if (!*best || total > (*best)->steps) *best = Explanation{conventions, total};
}

void Explainer::TryScaled(FileConventions conventions, std::optional<Explanation>* best) const {
  const std::optional<double> scale = ScaleOf(steps_, Interpret(conventions, odometry_));
  for (const Unit& unit : kUnits) {
    conventions.scale = unit.metres;
    Try(conventions, best);
  }
  if (!scale) return;
  conventions.scale = *scale;
  Try(conventions, best);
}

std::optional<Explanation> Explainer::Find() const {
  std::optional<Explanation> best;
  if (2 * AgreeAsRead() > steps_.size()) return best;
  std::vector<FileConventions> ways = QuaternionConventions();
  const std::vector<FileConventions> axes = AxesConventions();
  ways.insert(ways.end(), axes.begin(), axes.end());
  TryScaled({}, &best);
  for (const FileConventions& way : ways) Try(way, &best);
  if (best) return best;
  for (const FileConventions& way : ways) TryScaled(way, &best);
  return best;
}

// ---- in words ----

std::string TextOfNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

std::string UnitInWords(double metres) {
  for (const Unit& unit : kUnits) {
    if (unit.metres == metres) return "in " + std::string(unit.name);
  }
  return "with " + TextOfNumber(metres) + " m per unit";
}

struct Words {
  std::string as, flags;
};

void Add(const std::string& as, const std::string& flag, Words* words) {
  words->as += (words->as.empty() ? "" : " and ") + as;
  words->flags += " " + flag;
}

Words InWords(const FileConventions& conventions) {
  Words words;
  if (conventions.w_first) Add("with w first in its quaternions", "--quaternions=wxyz", &words);
  if (conventions.body_from_world) Add("as body from world", "--inverse", &words);
  if (!conventions.axes.isIdentity(0.0)) {
    const std::string axes = AxesText(conventions.axes);
    Add("with other axes (our x,y,z being its " + axes + ")", "--axes=" + axes, &words);
  }
  if (conventions.scale != 1.0) {
    Add(UnitInWords(conventions.scale), "--scale=" + TextOfNumber(conventions.scale), &words);
  }
  return words;
}

std::string NameOf(const RobotSite& robot) {
  return robot.name + ": the odometry" +
         (robot.odometry_file.empty() ? "" : " " + robot.odometry_file);
}

std::string DisagreementText(const RobotSite& robot, const Explainer& explainer,
                             const Explanation& found) {
  const Words words = InWords(found.conventions);
  return NameOf(robot) + " agrees with " + std::to_string(explainer.AgreeAsRead()) + " of " +
         std::to_string(explainer.size()) +
         " registrations of consecutive scans as it stands, and with " +
         std::to_string(found.steps) + " if it is taken " + words.as +
         ": make it so by planegraph convert" + words.flags;
}

// Scans that stand farther apart than both of them reach have nothing in common.
std::optional<std::string> LengthText(std::size_t robot, const Site& site,
                                      const std::vector<ScanRecord>& scans) {
  std::vector<double> lengths, reaches;
  std::size_t too_long = 0;
  for (const OdometryStep& step : OdometrySteps(site, scans)) {
    if (scans[step.target].robot != robot) continue;
    lengths.push_back(step.target_from_source.translation.norm());
    reaches.push_back(scans[step.target].reach + scans[step.source].reach);
    too_long += lengths.back() > reaches.back() ? 1 : 0;
  }
  if (2 * too_long <= lengths.size()) return std::nullopt;
  return NameOf(site.robots[robot]) + " has steps of " + TextOfNumber(Median(std::move(lengths))) +
         " m (median) between scans that reach " + TextOfNumber(Median(std::move(reaches)) / 2.0) +
         " m: is its unit the metre? Of millimetres planegraph convert --scale=0.001 makes metres";
}

}  // namespace

std::vector<std::string> OdometryConventionWarnings(const Site& site,
                                                    const std::vector<ScanRecord>& scans,
                                                    const std::vector<PairRecord>& chain) {
  std::vector<std::string> warnings;
  for (std::size_t r = 0; r < site.robots.size(); ++r) {
    const RobotSite& robot = site.robots[r];
    if (!robot.odometry) continue;
    const Explainer explainer(RegisteredSteps(r, scans, chain), *robot.odometry);
    if (const auto found = explainer.Find()) {
      warnings.push_back(DisagreementText(robot, explainer, *found));
    } else if (const auto text = LengthText(r, site, scans)) {
      warnings.push_back(*text);
    }
  }
  return warnings;
}

}  // namespace planegraph
