#include "planegraph/io/g2o_io.h"

#include <array>
#include <cmath>
#include <unordered_set>

#include "io/file_bytes.h"
#include "io/g2o_parser.h"
#include "io/text_scanner.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr char kVertex3[] = "VERTEX_SE3:QUAT", kVertex2[] = "VERTEX_SE2";
constexpr char kEdge3[] = "EDGE_SE3:QUAT", kEdge2[] = "EDGE_SE2", kFix[] = "FIX";
constexpr char kPrior3[] = "EDGE_SE3_PRIOR", kPrior2[] = "EDGE_PRIOR_SE2";
constexpr char kOffset[] = "PARAMS_SE3OFFSET";

// The words after the tag of one line, taken from left to right.
class LineFields {
 public:
  LineFields(std::string_view rest, const std::string& file, std::size_t line)
      : rest_(rest), fields_(rest, ' '), file_(file), line_(line) {}

  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError::AtLine(file_, line_, reason);
  }
  double Number() {
    double value = 0.0;
    const auto result = fields_.Next(&value);
    if (result == FieldReader::Result::kEnd) Fail("numbers are missing in " + Excerpt(rest_));
    if (!std::isfinite(value)) Fail("holds what is no finite number: " + Excerpt(rest_));
    return value;
  }
  // Ids up to 2^53 are exact.
  long long Id() {
    const double value = Number();
    if (std::abs(value) > 9007199254740992.0 || value != std::floor(value)) {
      Fail("an id is not an integer");
    }
    return static_cast<long long>(value);
  }
  Pose2 PlanarPose() {
    const double x = Number(), y = Number(), angle = Number();
    return {x, y, angle};
  }
  Rigid3 Pose() {
    std::array<double, 7> v{};
    for (double& value : v) value = Number();
    const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
    constexpr double kTolerance = 1e-2;
    if (!(std::abs(rotation.norm() - 1.0) <= kTolerance)) Fail("the quaternion's norm is not 1");
    return {rotation.normalized(), {v[0], v[1], v[2]}};
  }
  // The upper triangle, row by row.
  template <typename Matrix>
  Matrix Information() {
    Matrix information;
    for (Eigen::Index row = 0; row < information.rows(); ++row) {
      for (Eigen::Index column = row; column < information.cols(); ++column) {
        information(row, column) = information(column, row) = Number();
      }
    }
    return information;
  }
  void ExpectEnd() {
    double value = 0.0;
    if (fields_.Next(&value) != FieldReader::Result::kEnd) Fail("has too many numbers");
  }
  bool AtEnd() const { return FieldReader(fields_).Next(&ignored_) == FieldReader::Result::kEnd; }

 private:
  std::string_view rest_;
  FieldReader fields_;
  const std::string& file_;
  std::size_t line_;
  mutable double ignored_ = 0.0;
};

class G2oParser {
 public:
  explicit G2oParser(const std::string& file) : file_(file) {}

  G2oGraph Parse(std::string_view bytes) {
    LineReader lines(bytes);
    std::string_view line;
    while (lines.Next(&line)) {
      line = Trim(line);
      if (line.empty() || line.front() == '#') continue;
      ParseLine(line, lines.number());
    }
    if (ids_.empty()) {
      throw InputError::InFile(file_, "holds no VERTEX_SE3:QUAT and no VERTEX_SE2");
    }
    CheckEnds(graph_.edges3, edge3_lines_);
    CheckEnds(graph_.edges2, edge2_lines_);
    CheckIds(graph_.priors3, prior3_lines_);
    CheckIds(graph_.priors2, prior2_lines_);
    CheckOffsets();
    return std::move(graph_);
  }

 private:
  void ParseLine(std::string_view line, std::size_t number) {
    const std::size_t length = std::min(line.find_first_of(" \t"), line.size());
    const std::string_view tag = line.substr(0, length);
    LineFields fields(line.substr(length), file_, number);
    if (tag == kVertex3) {
      const long long id = NewId(&fields);
      graph_.vertices3.push_back({id, fields.Pose()});
    } else if (tag == kVertex2) {
      const long long id = NewId(&fields);
      graph_.vertices2.push_back({id, fields.PlanarPose()});
    } else if (tag == kEdge3) {
      const long long from = fields.Id(), to = fields.Id();
      const Rigid3 measurement = fields.Pose();
      graph_.edges3.push_back({from, to, measurement, fields.Information<Matrix6d>()});
      edge3_lines_.push_back(number);
    } else if (tag == kEdge2) {
      const long long from = fields.Id(), to = fields.Id();
      const Pose2 measurement = fields.PlanarPose();
      graph_.edges2.push_back({from, to, measurement, fields.Information<Eigen::Matrix3d>()});
      edge2_lines_.push_back(number);
    } else if (tag == kPrior3) {
      const long long id = fields.Id(), offset = fields.Id();
      const Rigid3 measurement = fields.Pose();
      graph_.priors3.push_back({id, measurement, fields.Information<Matrix6d>()});
      prior3_lines_.push_back(number);
      prior3_offsets_.push_back(offset);
    } else if (tag == kPrior2) {
      const long long id = fields.Id();
      const Pose2 measurement = fields.PlanarPose();
      graph_.priors2.push_back({id, measurement, fields.Information<Eigen::Matrix3d>()});
      prior2_lines_.push_back(number);
    } else if (tag == kOffset) {
      const long long id = fields.Id();
      const Rigid3 offset = fields.Pose();
      const bool moves = !offset.translation.isZero(0.0) || offset.rotation.vec().norm() > 1e-12;
      if (moves) moved_offsets_.insert(id);
    } else if (tag == kFix) {
      do graph_.fixed.push_back(fields.Id());
      while (!fields.AtEnd());
    } else {
      ++graph_.unknown[TagName(tag, fields)];
      return;
    }
    fields.ExpectEnd();
  }

  // Tags are words of letters: anything else is no g2o at all.
  static std::string TagName(std::string_view tag, const LineFields& fields) {
    const bool letter = tag.front() >= 'A' && tag.front() <= 'Z';
    if (!letter) fields.Fail("is not a g2o line: " + Excerpt(tag));
    return std::string(tag);
  }

  long long NewId(LineFields* fields) {
    const long long id = fields->Id();
    if (!ids_.insert(id).second) fields->Fail("vertex " + std::to_string(id) + " occurs twice");
    return id;
  }

  template <typename Edges>
  void CheckEnds(const Edges& edges, const std::vector<std::size_t>& lines) const {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      for (const long long id : {edges[i].from, edges[i].to}) CheckId(id, lines[i]);
    }
  }
  template <typename Priors>
  void CheckIds(const Priors& priors, const std::vector<std::size_t>& lines) const {
    for (std::size_t i = 0; i < priors.size(); ++i) CheckId(priors[i].id, lines[i]);
  }
  // The offset may be defined after the prior.
  void CheckOffsets() const {
    for (std::size_t i = 0; i < prior3_offsets_.size(); ++i) {
      if (!moved_offsets_.count(prior3_offsets_[i])) continue;
      throw InputError::AtLine(file_, prior3_lines_[i], "its sensor offset is not the identity");
    }
  }
  void CheckId(long long id, std::size_t line) const {
    if (ids_.count(id)) return;
    throw InputError::AtLine(file_, line, "no vertex has the id " + std::to_string(id));
  }

  const std::string& file_;
  G2oGraph graph_;
  std::unordered_set<long long> ids_, moved_offsets_;
  std::vector<long long> prior3_offsets_;
  std::vector<std::size_t> edge3_lines_, edge2_lines_, prior3_lines_, prior2_lines_;
};

// ---- writing ----

class G2oText {
 public:
  void Tag(const char* tag) { text_ += tag; }
  void Add(long long id) { AppendNumber(&(text_ += ' '), id); }
  void Add(double value) { AppendNumber(&(text_ += ' '), value); }
  void Add(const Pose2& pose) {
    for (const double value : {pose.x, pose.y, pose.angle}) Add(value);
  }
  void Add(const Rigid3& pose) {
    for (int axis = 0; axis < 3; ++axis) Add(pose.translation[axis]);
    for (int axis = 0; axis < 4; ++axis) Add(pose.rotation.coeffs()[axis]);
  }
  template <typename Matrix>
  void AddUpperTriangle(const Matrix& information) {
    for (Eigen::Index row = 0; row < information.rows(); ++row) {
      for (Eigen::Index column = row; column < information.cols(); ++column) {
        Add(information(row, column));
      }
    }
  }
  void EndLine() { text_ += '\n'; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

template <typename Vertices>
void AppendVertices(const char* tag, const Vertices& vertices, G2oText* text) {
  for (const auto& vertex : vertices) {
    text->Tag(tag);
    text->Add(vertex.id);
    text->Add(vertex.pose);
    text->EndLine();
  }
}

// g2o's 3-D priors name the parameters of their sensor; ours is at the pose itself.
void AppendPriors(const G2oGraph& graph, G2oText* text) {
  if (!graph.priors3.empty()) {
    text->Tag(kOffset);
    text->Add(0LL);
    text->Add(Rigid3());
    text->EndLine();
  }
  for (const G2oPrior3& prior : graph.priors3) {
    text->Tag(kPrior3);
    text->Add(prior.id);
    text->Add(0LL);
    text->Add(prior.measurement);
    text->AddUpperTriangle(prior.information);
    text->EndLine();
  }
  for (const G2oPrior2& prior : graph.priors2) {
    text->Tag(kPrior2);
    text->Add(prior.id);
    text->Add(prior.measurement);
    text->AddUpperTriangle(prior.information);
    text->EndLine();
  }
}

template <typename Edges>
void AppendEdges(const char* tag, const Edges& edges, G2oText* text) {
  for (const auto& edge : edges) {
    text->Tag(tag);
    text->Add(edge.from);
    text->Add(edge.to);
    text->Add(edge.measurement);
    text->AddUpperTriangle(edge.information);
    text->EndLine();
  }
}

}  // namespace

G2oGraph ParseG2o(std::string_view bytes, const std::string& file) {
  return G2oParser(file).Parse(bytes);
}

G2oGraph ReadG2o(const std::string& path) { return ParseG2o(FileBytes(path).view(), path); }

void WriteG2o(const std::string& path, const G2oGraph& graph) {
  G2oText text;
  AppendVertices(kVertex3, graph.vertices3, &text);
  AppendVertices(kVertex2, graph.vertices2, &text);
  for (const long long id : graph.fixed) {
    text.Tag(kFix);
    text.Add(id);
    text.EndLine();
  }
  AppendPriors(graph, &text);
  AppendEdges(kEdge3, graph.edges3, &text);
  AppendEdges(kEdge2, graph.edges2, &text);
  WriteTextFile(path, text.text());
}

Trajectory TrajectoryOf(const G2oGraph& graph) {
  Trajectory trajectory;
  trajectory.has_times = false;
  for (const G2oVertex3& vertex : graph.vertices3) {
    trajectory.times.push_back(static_cast<double>(vertex.id));
    trajectory.poses.push_back(vertex.pose);
  }
  for (const G2oVertex2& vertex : graph.vertices2) {
    const Eigen::AngleAxisd turn(vertex.pose.angle, Eigen::Vector3d::UnitZ());
    trajectory.times.push_back(static_cast<double>(vertex.id));
    trajectory.poses.emplace_back(Eigen::Quaterniond(turn),
                                  Eigen::Vector3d(vertex.pose.x, vertex.pose.y, 0.0));
  }
  return trajectory;
}

}  // namespace planegraph
