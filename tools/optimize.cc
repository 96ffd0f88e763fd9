// `planegraph optimize`: a pose graph by itself.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "planegraph/base/error.h"
#include "planegraph/graph/factor_losses.h"
#include "planegraph/pose_graph/certificate.h"
#include "planegraph/pose_graph/g2o_conversion.h"
#include "planegraph/pose_graph/robust_optimization.h"
#include "tools/command.h"
#include "tools/common_flags.h"

DEFINE_string(init, "chordal", "start: chordal (from the edges alone) or given (the file's poses)");
DEFINE_string(
    information, "file",
    "information matrices: file (as they are), isotropic (SE-Sync's tau and kappa of each) "
    "or nearest (the nearest positive semi-definite ones)");
DEFINE_string(rotation_error, "half",
              "rotation error that the file's matrices belong to: half (g2o's, half the angle) or "
              "full");
DEFINE_bool(certify, false,
            "with --information=isotropic: prove that the result is the global minimum, and step "
            "away from a local one");
DECLARE_string(loss);

namespace planegraph::tools {
namespace {

// The value of a flag that has to be one of `names`: its index.
int Choice(const std::string& flag, const std::string& value,
           const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == value) return static_cast<int>(i);
    list += (i == 0 ? "" : " or ") + names[i];
  }
  throw UsageError("--" + flag + " must be " + list + ", not '" + value + "'");
}

struct Settings {
  bool chordal = true;
  G2oConversionOptions conversion;
  LossSpec loss;
  std::optional<GncOptions> gnc;
};

// A pose graph has factors of one type.
LossSpec EdgeLoss(const std::string& text) {
  const FactorLosses losses = ParseFactorLosses(text, {}, BuiltinFactors());
  const auto own = losses.by_type.find("relative_pose");
  if (losses.by_type.size() > (own == losses.by_type.end() ? 0u : 1u)) {
    throw UsageError("a pose graph has a loss for relative_pose alone");
  }
  return own == losses.by_type.end() ? losses.general : own->second;
}

Settings SettingsFromFlags() {
  Settings settings;
  settings.chordal = Choice("init", FLAGS_init, {"chordal", "given"}) == 0;
  settings.conversion.information = static_cast<InformationUse>(
      Choice("information", FLAGS_information, {"file", "isotropic", "nearest"}));
  settings.conversion.rotation_error =
      static_cast<RotationError>(Choice("rotation_error", FLAGS_rotation_error, {"half", "full"}));
  // The flag is shared with `map`, whose default is another.
  const bool given = !gflags::GetCommandLineFlagInfoOrDie("loss").is_default;
  const std::string loss = given ? FLAGS_loss : "none";
  settings.loss = EdgeLoss(loss);
  if (IsGraduated(settings.loss)) {
    settings.gnc = GncOptions{KernelOf(settings.loss), settings.loss.scale};
  }
  if (!FLAGS_certify) return settings;
  if (settings.conversion.information != InformationUse::kIsotropic) {
    throw UsageError("--certify proves the isotropic problem: it needs --information=isotropic");
  }
  if (settings.loss.name != "none" && settings.loss.name != "gnc_tls") {
    throw UsageError("--certify needs --loss=none or --loss=gnc_tls");
  }
  return settings;
}

struct Outcome {
  double initial_cost = 0.0, final_cost = 0.0;
  PoseGraphSummary summary;
  std::optional<GncSummary> gnc;
  std::optional<Certificate> certificate;
  int escapes = 0;
  double seconds_start = 0.0, seconds_certificate = 0.0;
  std::size_t rejected = 0, robust = 0, parts = 0;
};

template <int Dim>
std::size_t CountParts(const PoseGraph<Dim>& graph) {
  const std::vector<int> parts = ConnectedParts(graph);
  std::size_t count = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) count += parts[i] == static_cast<int>(i);
  return count;
}

template <int Dim>
void SolveRobustly(const GncOptions& options, PoseGraph<Dim>* graph, Outcome* outcome) {
  outcome->gnc = OptimizeByGnc(graph, options);
  outcome->summary = outcome->gnc->last;
  outcome->summary.final_cost = outcome->gnc->robust_cost;
  for (std::size_t k = 0; k < graph->edges.size(); ++k) {
    outcome->robust += graph->edges[k].robust;
    outcome->rejected += outcome->gnc->weights[k] < 0.5;
  }
}

// With graduated non-convexity: of the edges that it kept.
template <int Dim>
void SolveCertified(PoseGraph<Dim>* graph, Outcome* outcome) {
  PoseGraph<Dim> kept = *graph;
  if (outcome->gnc) {
    kept.edges.clear();
    for (std::size_t k = 0; k < graph->edges.size(); ++k) {
      if (outcome->gnc->weights[k] >= 0.5) kept.edges.push_back(graph->edges[k]);
    }
  }
  const CertifiedSummary certified = OptimizeCertified(&kept);
  graph->poses = kept.poses;
  outcome->certificate = certified.certificate;
  outcome->escapes = certified.escapes;
  outcome->seconds_certificate = certified.seconds_certificate;
  if (!outcome->gnc) outcome->summary = certified.optimization;
}

template <int Dim>
void SolveGraph(const Settings& settings, PoseGraph<Dim>* graph, Outcome* outcome) {
  if (settings.gnc) SolveRobustly(*settings.gnc, graph, outcome);
  if (FLAGS_certify) SolveCertified(graph, outcome);
  if (settings.gnc || FLAGS_certify) return;
  PoseGraphOptions options;
  options.loss = settings.loss;
  outcome->summary = OptimizePoseGraph(graph, options);
}

template <int Dim>
Outcome Optimize(const Settings& settings, const std::string& path, G2oGraph* file) {
  PoseGraph<Dim> graph = MakePoseGraph<Dim>(*file, path, settings.conversion);
  if (FLAGS_certify && std::count(graph.fixed.begin(), graph.fixed.end(), true) > 1) {
    throw InputError::InFile(path,
                             "more than one pose is held (FIX, and the world where there are "
                             "priors): --certify proves graphs with a free gauge alone");
  }
  Outcome outcome;
  outcome.parts = CountParts(graph);
  const double begin = SecondsSinceStart();
  const bool robust = settings.gnc || settings.loss.name != "none";
  if (settings.chordal) robust ? InitializeChordalFromTrusted(&graph) : InitializeChordal(&graph);
  outcome.seconds_start = SecondsSinceStart() - begin;
  outcome.initial_cost = GraphCost(graph);
  SolveGraph(settings, &graph, &outcome);
  outcome.final_cost = outcome.summary.final_cost;
  // SE-Sync's F has no half.
  if (settings.conversion.information == InformationUse::kIsotropic) {
    outcome.initial_cost *= 2.0;
    outcome.final_cost *= 2.0;
  }
  StorePoses(graph, file);
  return outcome;
}

nlohmann::json ToJson(const Outcome& outcome, const G2oGraph& file, bool planar) {
  nlohmann::json json = {{"poses", planar ? file.vertices2.size() : file.vertices3.size()},
                         {"edges", planar ? file.edges2.size() : file.edges3.size()},
                         {"dimension", planar ? 2 : 3},
                         {"parts", outcome.parts},
                         {"initial_cost", outcome.initial_cost},
                         {"final_cost", outcome.final_cost},
                         {"converged", outcome.summary.converged},
                         {"iterations", outcome.summary.iterations},
                         {"factorizations", outcome.summary.factorizations},
                         {"seconds_init", outcome.seconds_start},
                         {"seconds_solve", outcome.summary.seconds},
                         {"unknown_tags", file.unknown}};
  if (outcome.gnc) {
    json["rounds"] = outcome.gnc->rounds;
    json["loop_closures"] = outcome.robust;
    json["rejected"] = outcome.rejected;
  }
  if (outcome.certificate) {
    json["certified"] = outcome.certificate->certified;
    json["escapes"] = outcome.escapes;
    json["suboptimality_bound"] = outcome.certificate->suboptimality_bound;
    json["seconds_certificate"] = outcome.seconds_certificate;
  }
  return json;
}

void PrintSummary(const Outcome& outcome) {
  std::printf("cost %.9g -> %.9g in %d iterations, %.3f s (start %.3f s)%s\n", outcome.initial_cost,
              outcome.final_cost, outcome.summary.iterations, outcome.summary.seconds,
              outcome.seconds_start, outcome.summary.converged ? "" : ", not converged");
  if (outcome.gnc) {
    std::printf("%zu of %zu loop closures rejected in %d rounds\n", outcome.rejected,
                outcome.robust, outcome.gnc->rounds);
  }
  if (!outcome.certificate) return;
  if (outcome.escapes > 0) std::printf("%d local minima left behind\n", outcome.escapes);
  if (outcome.certificate->certified) {
    std::printf("certified: no poses have a cost lower by more than %.3g (%.3f s)\n",
                outcome.certificate->suboptimality_bound, outcome.seconds_certificate);
  } else {
    std::printf("not certified: the cost may be lower by up to %.6g\n",
                outcome.certificate->suboptimality_bound);
  }
}

int RunOptimize(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 1, 1);
  RequireFlag("output");
  const Settings settings = SettingsFromFlags();
  G2oGraph file = ReadG2o(arguments[0]);
  for (const auto& [tag, count] : file.unknown) {
    LOG(WARNING) << arguments[0] << ": " << count << " lines of the unknown tag " << tag
                 << " are passed over";
  }
  const bool planar = IsPlanar(file, arguments[0]);
  const Outcome outcome = planar ? Optimize<2>(settings, arguments[0], &file)
                                 : Optimize<3>(settings, arguments[0], &file);
  WriteG2o(FLAGS_output, file);
  if (WantsText()) PrintSummary(outcome);
  EmitResult(ToJson(outcome, file, planar), false);
  if (!outcome.summary.converged) throw NoResultError("the optimization did not converge");
  if (outcome.certificate && !outcome.certificate->certified) {
    throw NoResultError("the result is not certified as the global minimum");
  }
  return 0;
}

}  // namespace

Command OptimizeCommand() {
  return {"optimize",
          "GRAPH.g2o",
          "a pose graph by itself: robust, certified",
          {"output", "init", "information", "rotation_error", "loss", "certify"},
          RunOptimize};
}

}  // namespace planegraph::tools
