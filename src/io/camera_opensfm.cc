// OpenSfM's reconstruction.json: shots with a rotation vector and a translation, world to camera.
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/camera_formats.h"
#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

using nlohmann::json;

// Notes the names of the first reconstruction's shots in the file's order (the library sorts the
// keys of objects).
json ParseInOrder(std::string_view bytes, const std::string& file,
                  std::vector<std::string>* shots) {
  std::size_t arrays_passed = 0;
  bool in_shots = false;
  const auto note = [&](int depth, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_end && depth == 1) ++arrays_passed;
    if (event != json::parse_event_t::key || arrays_passed > 0) return true;
    if (depth == 2) in_shots = parsed == "shots";
    if (depth == 3 && in_shots) shots->push_back(parsed.get<std::string>());
    return true;
  };
  try {
    return json::parse(bytes, note);
  } catch (const json::parse_error& error) {
    throw InputError::AtByte(file, error.byte, "is not valid JSON");
  } catch (const json::out_of_range&) {
    throw InputError::InFile(file, "holds a number that is out of range");
  }
}

class OpenSfmReader {
 public:
  OpenSfmReader(const json& reconstruction, const std::string& file)
      : reconstruction_(reconstruction), file_(file) {}

  Camera Shot(const std::string& name) const {
    const json& shot = Member(reconstruction_["shots"], name, "shots");
    Camera camera;
    camera.image = name;
    camera.camera_from_model = {ExpSO3(Vector(shot, "rotation", name)),
                                Vector(shot, "translation", name)};
    camera.focal = Focal(shot);
    camera.valid = true;
    return camera;
  }
  std::vector<Eigen::Vector3d> Points() const {
    std::vector<Eigen::Vector3d> points;
    const auto all = reconstruction_.find("points");
    if (all == reconstruction_.end() || !all->is_object()) return points;
    for (const auto& [id, point] : all->items()) {
      points.push_back(Vector(point, "coordinates", "point " + id));
    }
    return points;
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError::InFile(file_, reason);
  }
  const json& Member(const json& object, const std::string& key, const std::string& where) const {
    if (!object.is_object() || !object.contains(key)) Fail(where + " has no `" + key + "`");
    return object[key];
  }
  Eigen::Vector3d Vector(const json& object, const std::string& key,
                         const std::string& where) const {
    const json& list = Member(object, key, where);
    Eigen::Vector3d vector = Eigen::Vector3d::Constant(NAN);
    for (std::size_t i = 0; list.is_array() && list.size() == 3 && i < 3; ++i) {
      if (list[i].is_number()) vector[static_cast<Eigen::Index>(i)] = list[i].get<double>();
    }
    if (!vector.allFinite()) Fail("`" + key + "` of " + where + " is not three finite numbers");
    return vector;
  }
  // Some projection types have other parameters: the focal length is then unknown.
  double Focal(const json& shot) const {
    const auto id = shot.find("camera");
    const auto cameras = reconstruction_.find("cameras");
    if (id == shot.end() || !id->is_string() || cameras == reconstruction_.end()) return 0.0;
    const auto camera = cameras->find(id->get<std::string>());
    if (camera == cameras->end() || !camera->is_object()) return 0.0;
    for (const char* key : {"focal", "focal_x"}) {
      const auto focal = camera->find(key);
      if (focal == camera->end() || !focal->is_number()) continue;
      return std::max(focal->get<double>(), 0.0);
    }
    return 0.0;
  }

  const json& reconstruction_;
  const std::string& file_;
};

}  // namespace

CameraModel ParseOpenSfm(std::string_view bytes, const std::string& file) {
  std::vector<std::string> shots;
  const json all = ParseInOrder(bytes, file, &shots);
  const bool usable = all.is_array() && !all.empty() && all[0].is_object();
  if (!usable || !all[0].contains("shots") || !all[0]["shots"].is_object()) {
    throw InputError::InFile(file, "is no OpenSfM reconstruction: no list of objects with `shots`");
  }
  const OpenSfmReader reader(all[0], file);
  CameraModel model;
  model.format = "opensfm";
  model.ignored_models = all.size() - 1;
  for (const std::string& name : shots) model.cameras.push_back(reader.Shot(name));
  model.points = reader.Points();
  return model;
}

}  // namespace planegraph
