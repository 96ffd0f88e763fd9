// `planegraph optimize` on small graphs and on the graph of a run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/tool_runner.h"
#include "io/test_files.h"

namespace planegraph::cli {
namespace {

using ::testing::HasSubstr;

// The upper triangle of the identity, row by row.
const std::string kIdentity6 = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";

class OptimizeJob : public TestFolder {
 protected:
  // A square of four poses whose last edge contradicts the others by 0.4 m along x.
  std::string Square() {
    const std::string path = Path("square.g2o");
    std::ofstream(path) << "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"
                        << "VERTEX_SE3:QUAT 2 1 1 0 0 0 0 1\nVERTEX_SE3:QUAT 3 0 1 0 0 0 0 1\n"
                        << "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1" << kIdentity6 << "\n"
                        << "EDGE_SE3:QUAT 1 2 0 1 0 0 0 0 1" << kIdentity6 << "\n"
                        << "EDGE_SE3:QUAT 2 3 -1 0 0 0 0 0 1" << kIdentity6 << "\n"
                        << "EDGE_SE3:QUAT 3 0 0.4 -1 0 0 0 0 1" << kIdentity6 << "\n";
    return path;
  }
  // All numbers of the vertices.
  static std::vector<double> Vertices(const std::string& path) {
    std::vector<double> numbers;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string tag;
      words >> tag;
      if (tag.rfind("VERTEX", 0) != 0) continue;
      for (double number = 0.0; words >> number;) numbers.push_back(number);
    }
    return numbers;
  }
};

// Rotations stay, as nothing but the translations contradict; 0.4 m over four equal edges is 0.1 m
// each, F = sum tau |r|^2 = 4 * 0.01 with tau = 1, and 0.5 * that by the file's information.
TEST_F(OptimizeJob, SharesAContradictionAndCertifiesIt) {
  const std::string graph = Square();
  Outcome run = RunTool("optimize --json " + graph + " --output=" + Path("a.g2o"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(nlohmann::json::parse(run.out)["final_cost"].get<double>(), 0.5 * 0.04 + 1e-12);
  run = RunTool("optimize --json --information=isotropic --certify " + graph +
                " --output=" + Path("b.g2o"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_TRUE(json["certified"].get<bool>());
  EXPECT_LE(json["final_cost"].get<double>(), 0.04 + 1e-12);
  EXPECT_LE(json["suboptimality_bound"].get<double>(), 1e-6 * json["final_cost"].get<double>());
}

TEST_F(OptimizeJob, SaysWhatIsWrong) {
  const std::string graph = Square();
  EXPECT_EQ(RunTool("optimize " + graph).exit_code, 1);
  const std::string output = " --output=" + Path("out.g2o");
  EXPECT_EQ(RunTool("optimize --certify " + graph + output).exit_code, 1);
  // What the certificate cannot prove is the file's business, not a defect of the program.
  std::ofstream(Path("fixed.g2o")) << std::ifstream(graph).rdbuf() << "FIX 0\nFIX 2\n";
  const Outcome fixed =
      RunTool("optimize --information=isotropic --certify " + Path("fixed.g2o") + output);
  EXPECT_EQ(fixed.exit_code, 2);
  EXPECT_THAT(fixed.err, HasSubstr("more than one pose is held"));
  EXPECT_EQ(RunTool("optimize --init=zero " + graph + output).exit_code, 1);
  EXPECT_EQ(RunTool("optimize --loss=cubic " + graph + output).exit_code, 1);
  std::ofstream(Path("bad.g2o"))
      << "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 5 0 1 0 1\n";
  const Outcome run = RunTool("optimize " + Path("bad.g2o") + output);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err,
              HasSubstr("1 of 1 information matrices are indefinite, the first of edge 0-1"));
  EXPECT_FALSE(std::filesystem::exists(Path("out.g2o")));
  EXPECT_EQ(RunTool("optimize --information=nearest " + Path("bad.g2o") + output).exit_code, 0);
}

// The half-angle convention of graph.g2o: its poses are the optimum of its edges.
TEST_F(OptimizeJob, KeepsTheOptimumOfARun) {
  const std::string site = Path("corridor");
  ASSERT_EQ(RunTool("simulate --quiet --scene=corridor --scan_count=8 --beams=271 --sweeps=90 "
                    "--output_dir=" +
                    site)
                .exit_code,
            0);
  const Outcome map = RunTool("map --quiet " + site + "/site.yaml --output_dir=" + Path("out"));
  ASSERT_EQ(map.exit_code, 0) << map.err;
  for (const std::string init : {"given", "chordal"}) {
    const Outcome run = RunTool("optimize --init=" + init + " " + Path("out") +
                                "/graph.g2o --output=" + Path("again.g2o"));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const std::vector<double> before = Vertices(Path("out") + "/graph.g2o");
    const std::vector<double> after = Vertices(Path("again.g2o"));
    ASSERT_EQ(before.size(), after.size());
    ASSERT_EQ(before.size(), 8u * 8u);
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(before[i], after[i], 1e-6) << init;
  }
}

// Real false closures, a truth by time stamps: the commands of docs/pose_graphs.md. Odometry alone
// is 4.4 m off, and so is whoever rejects every closure.
TEST_F(OptimizeJob, BicoccaKeepsItsShapeAtEveryThreshold) {
  const std::string folder = PLANEGRAPH_SHARED_DATA "/posegraph/bicocca/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const std::string truth = Path("truth.tum"), graph = Path("out.g2o"), poses = Path("out.tum");
  ASSERT_EQ(RunTool("convert --quiet " + folder + "truth.g2o " + truth + " --stamps=" + folder +
                    "Bicocca_2009-02-25b-GT-extended.csv")
                .exit_code,
            0);
  for (const std::string threshold : {"0.000", "0.150", "0.300", "0.500"}) {
    SCOPED_TRACE(threshold);
    const std::string input = folder + "B25b_" + threshold + ".g2o";
    ASSERT_EQ(RunTool("optimize --quiet --loss=gnc_tls " + input + " --output=" + graph).exit_code,
              0);
    const std::string stamps = " --stamps=" + folder + "B25b_timestamps.txt";
    ASSERT_EQ(RunTool("convert --quiet " + graph + " " + poses + stamps).exit_code, 0);
    const Outcome run =
        RunTool("evaluate --json --max_time_difference=0.06 --confidence=0 --reference=" + truth +
                " --estimate=" + poses);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_LE(nlohmann::json::parse(run.out)["ate"]["rmse"].get<double>(), 1.2);
  }
}

}  // namespace
}  // namespace planegraph::cli
