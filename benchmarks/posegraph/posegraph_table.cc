// posegraph_table FOLDER: solve and certificate of the pose graphs *.g2o there (isotropic weights,
// chordal start) beside a plain Ceres solve in the same run, as a Markdown table. CPU seconds of
// the thread, medians of five. Then the minima with the information matrices as they are.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "planegraph/pose_graph/certificate.h"
#include "planegraph/pose_graph/g2o_conversion.h"
#include "planegraph/pose_graph/optimization.h"
#include "posegraph/ceres_pose_graph.h"
#include "thread_seconds.h"

namespace planegraph {
namespace {

constexpr int kRepeats = 5;

// Solve alone and with the chordal start, over the plain Ceres solve of the same machine and day:
// the best of SE-Sync 9b631b6b, GTSAM 0ffe6c93, g2o 34013227 (for the second of SE-Sync and GTSAM).
struct PeerRatio {
  double solve, with_start;
};
const std::map<std::string, PeerRatio>& Peers() {
  static const std::map<std::string, PeerRatio> peers = {
      {"parking-garage", {0.06 / 0.54, 0.31 / 0.54}},
      {"sphere2500", {0.36 / 0.88, 0.56 / 0.88}},
      {"torus3D", {1.04 / 1.32, 1.20 / 1.32}},
      {"sphere_bignoise_vertex3", {0.71 / 0.85, 0.71 / 0.85}},
      {"cubicle", {0.96 / 1.66, 1.65 / 1.66}}};
  return peers;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

template <typename Work>
double MedianSeconds(const Work& work) {
  std::vector<double> seconds;
  for (int i = 0; i < kRepeats; ++i) {
    const double start = ThreadSeconds();
    work();
    seconds.push_back(ThreadSeconds() - start);
  }
  return Median(seconds);
}

std::string Ratio(double ours, double peer, double ceres) {
  char text[64];
  if (peer == 0.0) {
    std::snprintf(text, sizeof text, "%.2f (–)", ours / ceres);
  } else {
    std::snprintf(text, sizeof text, "%.2f (%.2f)", ours / ceres, peer);
  }
  return text;
}

void PrintRow(const std::filesystem::path& path) {
  G2oConversionOptions options;
  options.information = InformationUse::kIsotropic;
  const PoseGraph3 file = MakePoseGraph<3>(ReadG2o(path.string()), path.string(), options);
  PoseGraph3 start = file, solved;
  const double chordal = MedianSeconds([&] { InitializeChordal(&(start = file)); });
  PoseGraphSummary summary;
  const double solve = MedianSeconds([&] { summary = OptimizePoseGraph(&(solved = start)); });
  Certificate certificate;
  // With the further Newton steps that the proof asks for where the solve stopped early.
  const double proof = MedianSeconds([&] {
    PoseGraph3 polished = solved;
    certificate = CertifyMinimum(&polished).certificate;
  });
  std::vector<double> ceres_seconds;
  CeresResult ceres;
  for (int i = 0; i < kRepeats; ++i) {
    ceres = SolveWithCeres(start);
    ceres_seconds.push_back(ceres.seconds);
  }
  const double reference = Median(ceres_seconds);
  const auto peer = Peers().find(path.stem().string());
  const PeerRatio ratio = peer == Peers().end() ? PeerRatio{0.0, 0.0} : peer->second;
  std::printf("| %s | %.10g | %s | %.2g | %.3f | %d | %.3f | %.3f | %.3f, %d | %s | %s |\n",
              path.stem().c_str(), 2.0 * summary.final_cost, certificate.certified ? "yes" : "no",
              certificate.suboptimality_bound / certificate.objective, chordal, summary.iterations,
              solve, proof, reference, ceres.iterations,
              Ratio(solve, ratio.solve, reference).c_str(),
              Ratio(chordal + solve, ratio.with_start, reference).c_str());
}

// 0.5 * sum of r^T information r with the file's matrices, for both readings of the rotation error.
std::string MinimumText(const G2oGraph& file, const std::string& path, RotationError error) {
  if (const std::size_t count = CheckInformation(file).indefinite; count > 0) {
    return "none: " + std::to_string(count) + " indefinite matrices";
  }
  PoseGraph3 graph = MakePoseGraph<3>(file, path, {InformationUse::kFile, error});
  InitializeChordal(&graph);
  char text[64];
  std::snprintf(text, sizeof text, "%.11g", OptimizePoseGraph(&graph).final_cost);
  return text;
}

// Minima by other means: refined from SE-Sync's solutions.
struct KnownMinima {
  const char *half = "–", *full = "–";
};
const std::map<std::string, KnownMinima>& Known() {
  static const std::map<std::string, KnownMinima> known = {
      {"smallGrid3D", {"229.07689", "512.69903"}},
      {"parking-garage", {"0.6193453", "0.6341922"}},
      {"sphere2500", {"363.57483", "675.60785"}},
      {"torus3D", {"7287.37322", "12113.52278"}},
      {"sphere_bignoise_vertex3", {"371931.3605", "1475794.23"}}};
  return known;
}

void PrintMinima(const std::filesystem::path& path) {
  const G2oGraph file = ReadG2o(path.string());
  const auto found = Known().find(path.stem().string());
  const KnownMinima known = found == Known().end() ? KnownMinima() : found->second;
  std::printf("| %s | %s | %s | %s | %s |\n", path.stem().c_str(),
              MinimumText(file, path.string(), RotationError::kHalf).c_str(), known.half,
              MinimumText(file, path.string(), RotationError::kFull).c_str(), known.full);
}

int Run(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".g2o") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::printf(
      "| graph | F | certified | relative gap at most | chordal s | steps | solve s | certificate "
      "s "
      "| plain Ceres s, steps | solve / Ceres (best peer) | start + solve / Ceres (best peer) |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& file : files) PrintRow(file);
  std::printf(
      "\n| graph | `half` | known minimum | `full` | known minimum |\n|---|---|---|---|---|\n");
  for (const auto& file : files) PrintMinima(file);
  return 0;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: posegraph_table FOLDER\n");
    return 1;
  }
  return planegraph::Run(argv[1]);
}
