// ATE and RPE of `planegraph evaluate`, of one estimate or of two beside each other.
#include <cmath>
#include <cstdio>

#include "planegraph/base/angles.h"
#include "planegraph/base/error.h"
#include "planegraph/evaluation/trajectory_plot.h"
#include "planegraph/evaluation/trajectory_warnings.h"
#include "planegraph/io/trajectory_io.h"
#include "tools/command.h"
#include "tools/common_flags.h"
#include "tools/evaluate_parts.h"
#include "tools/gnuplot.h"

namespace planegraph::tools {
namespace {

const std::size_t kBlocks = IntervalOptions().blocks;

using Part = Statistics PoseErrors::*;

// An estimate and what it is worth; what is missing has no result.
struct Judgement {
  std::string file;
  PosePairs pairs;
  std::optional<AteResult> ate;
  std::optional<RpeResult> rpe;
  std::vector<PoseErrors> ate_without, rpe_without;  // one block each
};

// ---- intervals ----

std::optional<Interval> IntervalOf(const PoseErrors& errors, const std::vector<PoseErrors>& without,
                                   Part part, double Statistics::*figure) {
  if (!(FLAGS_confidence > 0.0)) return {};
  std::vector<double> figures;
  for (const PoseErrors& rest : without) figures.push_back(rest.*part.*figure);
  return JackknifeMagnitude(errors.*part.*figure, figures, FLAGS_confidence);
}

nlohmann::json IntervalsJson(const PoseErrors& errors, const std::vector<PoseErrors>& without,
                             Part part) {
  const auto rmse = IntervalOf(errors, without, part, &Statistics::rmse);
  if (!rmse) return nullptr;
  return {{"level", FLAGS_confidence},
          {"method", "jackknife"},
          {"blocks", without.size()},
          {"rmse", ToJson(rmse)},
          {"mean", ToJson(IntervalOf(errors, without, part, &Statistics::mean))}};
}

// ---- JSON ----

nlohmann::json ToJson(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"std", s.std},   {"min", s.min},   {"max", s.max}};
}

nlohmann::json ToJson(const PoseErrors& errors, const std::vector<PoseErrors>& without) {
  nlohmann::json json = ToJson(errors.translation);
  json["interval"] = IntervalsJson(errors, without, &PoseErrors::translation);
  json["rotation"] = ToJson(errors.rotation);
  json["rotation"]["interval"] = IntervalsJson(errors, without, &PoseErrors::rotation);
  json["count"] = errors.count;
  return json;
}

nlohmann::json AteJson(const Judgement& judged) {
  if (!judged.ate) return nullptr;
  nlohmann::json json = ToJson(judged.ate->errors, judged.ate_without);
  json["alignment"] = FLAGS_align;
  const Sim3& sim = judged.ate->reference_from_estimate;
  const auto& q = sim.rotation.coeffs();
  json["reference_from_estimate"] = {
      {"scale", sim.scale},
      {"rotation", {q.x(), q.y(), q.z(), q.w()}},
      {"translation", {sim.translation.x(), sim.translation.y(), sim.translation.z()}}};
  return json;
}

nlohmann::json RpeJson(const Judgement& judged) {
  if (!judged.rpe) return nullptr;
  nlohmann::json json = ToJson(judged.rpe->errors, judged.rpe_without);
  json.update({{"delta", FLAGS_delta},
               {"delta_unit", FLAGS_delta_unit},
               {"pairs", FLAGS_pairs},
               {"pairs_from", FLAGS_pairs_from},
               {"alignment", FLAGS_align}});
  return json;
}

// ---- text ----

void PrintRow(const char* name, const Statistics& s, double factor) {
  std::printf("  %-18s %11.6f %11.6f %11.6f %11.6f %11.6f %11.6f\n", name, factor * s.rmse,
              factor * s.mean, factor * s.median, factor * s.std, factor * s.min, factor * s.max);
}

void PrintErrors(const PoseErrors& errors, const std::vector<PoseErrors>& without) {
  std::printf("  %-18s %11s %11s %11s %11s %11s %11s\n", "", "rmse", "mean", "median", "std", "min",
              "max");
  PrintRow("translation [m]", errors.translation, 1.0);
  PrintRow("rotation [rad]", errors.rotation, 1.0);
  PrintRow("rotation [deg]", errors.rotation, kDegreesPerRadian);
  const auto translation = IntervalOf(errors, without, &PoseErrors::translation, &Statistics::rmse);
  if (!translation) return;
  std::printf("  rmse, %g %% interval (jackknife, %zu blocks): %.6f to %.6f m",
              100.0 * FLAGS_confidence, without.size(), translation->low, translation->high);
  const auto rotation = IntervalOf(errors, without, &PoseErrors::rotation, &Statistics::rmse);
  std::printf(", %.6f to %.6f deg\n", kDegreesPerRadian * rotation->low,
              kDegreesPerRadian * rotation->high);
}

void PrintJudgement(const Judgement& judged) {
  const PosePairs& pairs = judged.pairs;
  std::printf("%s: %zu pairs of poses by %s", judged.file.c_str(), pairs.reference.size(),
              pairs.by_time ? "time" : "index");
  if (pairs.by_time) std::printf(", largest time difference %.6f s", pairs.max_time_difference);
  std::printf("\n");
  const double scale = judged.ate ? judged.ate->reference_from_estimate.scale : 1.0;
  if (judged.ate) {
    std::printf("ATE, alignment %s (scale %.6f), %zu poses\n", FLAGS_align.c_str(), scale,
                judged.ate->errors.count);
    PrintErrors(judged.ate->errors, judged.ate_without);
  }
  if (judged.rpe) {
    std::printf("RPE, delta %g %s, pairs %s, chosen on the %s, scale %.6f, %zu pairs\n",
                FLAGS_delta, FLAGS_delta_unit.c_str(), FLAGS_pairs.c_str(),
                FLAGS_pairs_from.c_str(), scale, judged.rpe->errors.count);
    PrintErrors(judged.rpe->errors, judged.rpe_without);
  }
}

// ---- one estimate ----

void ComputeErrors(Judgement* judged, nlohmann::json* result) {
  try {
    judged->ate = ComputeAte(judged->pairs, ParsePoseAlignment(FLAGS_align));
    judged->ate_without = AteWithoutBlocks(judged->pairs, *judged->ate, kBlocks);
  } catch (const NoResultError& error) {
    NoteFailure("ate", error.what(), result);
  }
  try {
    const double scale = judged->ate ? judged->ate->reference_from_estimate.scale : 1.0;
    judged->rpe = ComputeRpe(judged->pairs, RpeFlags(), scale);
    judged->rpe_without = RpeWithoutBlocks(*judged->rpe, kBlocks);
  } catch (const NoResultError& error) {
    NoteFailure("rpe", error.what(), result);
  }
}

Judgement Judge(const Trajectory& reference, const std::string& file, nlohmann::json* result) {
  const Trajectory estimate = ReadTrajectory(file);
  Judgement judged;
  judged.file = file;
  NoteWarnings(FileWarnings(estimate, file), result);
  judged.pairs = PairPoses(reference, estimate, FLAGS_max_time_difference, file);
  NoteWarnings(PairingWarnings(reference, FLAGS_reference, estimate, file, judged.pairs), result);
  ComputeErrors(&judged, result);
  if (judged.ate) NoteWarnings(PlacementWarnings(judged.pairs, *judged.ate), result);
  return judged;
}

// ---- two estimates ----

// Errors of unequal sets of poses are no comparison.
void RequireEqualPoses(const Judgement& a, const Judgement& b) {
  if (a.pairs.indices == b.pairs.indices) return;
  throw InputError::InFile(b.file, "pairs with other poses of the reference than " + a.file +
                                       " does (" + std::to_string(b.pairs.indices.size()) +
                                       " and " + std::to_string(a.pairs.indices.size()) +
                                       " pairs): their errors cannot be compared");
}

// The difference of the rmse's and its interval, of the same blocks left out in both.
nlohmann::json Difference(const PoseErrors& a, const std::vector<PoseErrors>& a_without,
                          const PoseErrors& b, const std::vector<PoseErrors>& b_without, Part part,
                          const char* name) {
  const double difference = (b.*part).rmse - (a.*part).rmse;
  std::optional<Interval> interval;
  if (FLAGS_confidence > 0.0 && a_without.size() == b_without.size()) {
    std::vector<double> without;
    for (std::size_t k = 0; k < a_without.size(); ++k) {
      without.push_back((b_without[k].*part).rmse - (a_without[k].*part).rmse);
    }
    interval = JackknifeInterval(difference, without, FLAGS_confidence);
  }
  if (WantsText())
    std::printf("  %-22s %+.6f%s\n", name, difference, IntervalText(interval).c_str());
  return {{"rmse", difference}, {"interval", tools::ToJson(interval)}};
}

void CompareErrors(const Judgement& a, const Judgement& b, nlohmann::json* difference) {
  if (WantsText()) std::printf("rmse of %s less that of %s\n", b.file.c_str(), a.file.c_str());
  if (a.ate && b.ate) {
    const PoseErrors &of_a = a.ate->errors, &of_b = b.ate->errors;
    (*difference)["ate"] =
        Difference(of_a, a.ate_without, of_b, b.ate_without, &PoseErrors::translation, "ATE [m]");
    (*difference)["ate_rotation"] = Difference(of_a, a.ate_without, of_b, b.ate_without,
                                               &PoseErrors::rotation, "ATE rotation [rad]");
  }
  // Pairs chosen by metres on the estimates may differ.
  if (a.rpe && b.rpe && a.rpe->pairs == b.rpe->pairs) {
    const PoseErrors &of_a = a.rpe->errors, &of_b = b.rpe->errors;
    (*difference)["rpe"] =
        Difference(of_a, a.rpe_without, of_b, b.rpe_without, &PoseErrors::translation, "RPE [m]");
    (*difference)["rpe_rotation"] = Difference(of_a, a.rpe_without, of_b, b.rpe_without,
                                               &PoseErrors::rotation, "RPE rotation [rad]");
  }
}

void ReportComparison(const Trajectory& reference, const Judgement& first,
                      std::vector<Judgement>* judged, nlohmann::json* result) {
  judged->push_back(Judge(reference, FLAGS_compare, result));
  const Judgement& other = judged->back();
  RequireEqualPoses(first, other);
  if (WantsText()) PrintJudgement(other);
  nlohmann::json& compare = (*result)["compare"];
  compare["estimate"] = FLAGS_compare;
  compare["ate"] = AteJson(other);
  compare["rpe"] = RpeJson(other);
  compare["difference"] = nlohmann::json::object();
  CompareErrors(first, other, &compare["difference"]);
}

// ---- plot ----

std::vector<Eigen::Vector3d> Places(const std::vector<MatrixPose>& poses) {
  std::vector<Eigen::Vector3d> places;
  for (const MatrixPose& pose : poses) places.push_back(pose.translation);
  return places;
}

std::string BaseName(const std::string& path) {
  const std::string trimmed = path.substr(0, path.find_last_not_of('/') + 1);
  return trimmed.substr(trimmed.find_last_of('/') + 1);
}

PlotSeries SeriesOf(const Judgement& judged) {
  PlotSeries series;
  series.name = BaseName(judged.file);
  series.positions =
      Places(judged.ate ? AlignedEstimate(judged.pairs, *judged.ate) : judged.pairs.estimate);
  if (judged.ate) series.ate = judged.ate->errors.translation_errors;
  if (!judged.rpe) return series;
  series.rpe = judged.rpe->errors.translation_errors;
  for (double angle : judged.rpe->errors.rotation_errors) {
    series.rpe_rotation.push_back(kDegreesPerRadian * angle);
  }
  for (const auto& pair : judged.rpe->pairs) {
    series.rpe_times.push_back(judged.pairs.times[pair.second]);
  }
  return series;
}

void Draw(const std::vector<Judgement>& judged, bool has_times) {
  TrajectoryPlot plot;
  plot.reference = Places(judged.front().pairs.reference);
  plot.times = judged.front().pairs.times;
  plot.has_times = has_times;
  char title[100];
  std::snprintf(title, sizeof title, "ATE, alignment %s", FLAGS_align.c_str());
  plot.ate_title = title;
  std::snprintf(title, sizeof title, "RPE over %g %s, pairs %s", FLAGS_delta,
                FLAGS_delta_unit.c_str(), FLAGS_pairs.c_str());
  plot.rpe_title = title;
  for (const Judgement& one : judged) plot.series.push_back(SeriesOf(one));
  DrawPlot(GnuplotScript(plot, PlotFormat(FLAGS_plot)), FLAGS_plot);
  if (WantsText()) std::printf("plot: %s\n", FLAGS_plot.c_str());
}

}  // namespace

void ReportTrajectory(nlohmann::json* result) {
  const Trajectory reference = ReadTrajectory(FLAGS_reference);
  NoteWarnings(FileWarnings(reference, FLAGS_reference), result);
  std::vector<Judgement> judged{Judge(reference, FLAGS_estimate, result)};
  const Judgement first = judged.front();
  if (WantsText()) PrintJudgement(first);
  result->update({{"ate", AteJson(first)},
                  {"rpe", RpeJson(first)},
                  {"paired_by", first.pairs.by_time ? "time" : "index"},
                  {"max_time_difference", first.pairs.max_time_difference},
                  {"unpaired", first.pairs.unpaired},
                  {"alignment", FLAGS_align},
                  {"count", first.pairs.reference.size()}});
  for (const char* key : {"delta", "delta_unit", "pairs", "pairs_from"}) {
    if (first.rpe) (*result)[key] = (*result)["rpe"][key];
  }
  if (!FLAGS_compare.empty()) ReportComparison(reference, first, &judged, result);
  if (!FLAGS_plot.empty()) Draw(judged, reference.has_times);
}

}  // namespace planegraph::tools
