// COLMAP's text model (cameras.txt, images.txt, points3D.txt), after its documentation of formats.
#include <cmath>

#include "io/camera_formats.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

// The lines that are neither empty nor comments.
bool NextRecord(LineReader* lines, std::string_view* line) {
  while (lines->Next(line)) {
    *line = Trim(*line);
    if (!line->empty() && line->front() != '#') return true;
  }
  return false;
}

// The words of one line from left to right; the rest may be taken as a whole.
class LineWords {
 public:
  LineWords(std::string_view line, const std::string& file, std::size_t number)
      : rest_(line), file_(file), number_(number) {}

  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError::AtLine(file_, number_, reason);
  }
  std::string_view Word() {
    rest_ = Trim(rest_);
    const std::size_t length = std::min(rest_.find_first_of(" \t"), rest_.size());
    if (length == 0) Fail("the line has too few words");
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }
  double Number() {
    const std::string_view word = Word();
    double value = 0.0;
    if (!ParseNumber(word, &value) || !std::isfinite(value)) {
      Fail("is not a finite number: " + Excerpt(word));
    }
    return value;
  }
  long long Id() {
    const std::string_view word = Word();
    long long value = 0;
    if (!ParseInteger(word, &value) || value < 0) Fail("is no id: " + Excerpt(word));
    return value;
  }
  std::string_view Rest() const { return Trim(rest_); }

 private:
  std::string_view rest_;
  const std::string& file_;
  std::size_t number_;
};

Camera ParseImage(LineWords* words, const FocalLengths& focal_lengths) {
  Camera camera;
  words->Id();
  Eigen::Quaterniond& rotation = camera.camera_from_model.rotation;
  for (double* part : {&rotation.w(), &rotation.x(), &rotation.y(), &rotation.z()}) {
    *part = words->Number();
  }
  if (!(std::abs(rotation.norm() - 1.0) <= 1e-2)) words->Fail("the quaternion's norm is not 1");
  rotation.normalize();
  for (double& part : camera.camera_from_model.translation) part = words->Number();
  const auto focal = focal_lengths.find(words->Id());
  camera.focal = focal == focal_lengths.end() ? 0.0 : focal->second;
  camera.image = std::string(words->Rest());
  if (camera.image.empty()) words->Fail("the image has no name");
  camera.valid = true;
  return camera;
}

// Each image has a second line, which may be empty: x, y and the point of every key point.
void SkipKeyPoints(LineReader* lines, const std::string& file) {
  std::string_view line;
  if (lines->Next(&line) && SplitWords(line).size() % 3 != 0) {
    throw InputError::AtLine(
        file, lines->number(),
        "is no line of key points (three numbers each), which every image has");
  }
}

}  // namespace

FocalLengths ParseColmapCameras(std::string_view bytes, const std::string& file) {
  FocalLengths focal_lengths;
  LineReader lines(bytes);
  std::string_view line;
  while (NextRecord(&lines, &line)) {
    LineWords words(line, file, lines.number());
    const long long id = words.Id();
    words.Word();
    words.Number();
    words.Number();
    const double focal = words.Number();
    if (!(focal > 0.0)) words.Fail("the focal length is not positive");
    focal_lengths[id] = focal;
  }
  return focal_lengths;
}

std::vector<Camera> ParseColmapImages(std::string_view bytes, const FocalLengths& focal_lengths,
                                      const std::string& file) {
  std::vector<Camera> cameras;
  LineReader lines(bytes);
  std::string_view line;
  while (NextRecord(&lines, &line)) {
    LineWords words(line, file, lines.number());
    cameras.push_back(ParseImage(&words, focal_lengths));
    SkipKeyPoints(&lines, file);
  }
  return cameras;
}

std::vector<Eigen::Vector3d> ParseColmapPoints(std::string_view bytes, const std::string& file) {
  std::vector<Eigen::Vector3d> points;
  LineReader lines(bytes);
  std::string_view line;
  while (NextRecord(&lines, &line)) {
    LineWords words(line, file, lines.number());
    words.Id();
    Eigen::Vector3d point;
    for (double& part : point) part = words.Number();
    points.push_back(point);
  }
  return points;
}

}  // namespace planegraph
