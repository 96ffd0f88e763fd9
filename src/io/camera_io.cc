#include "planegraph/io/camera_io.h"

#include <filesystem>

#include "io/camera_formats.h"
#include "io/file_bytes.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

// Reads `stem`.bin or `stem`.txt of a COLMAP folder; a default where there is neither.
template <typename Result>
Result ReadOptional(const fs::path& folder, const std::string& stem, bool binary,
                    Result (*parse_text)(std::string_view, const std::string&),
                    Result (*parse_binary)(std::string_view, const std::string&)) {
  const std::string path = (folder / (stem + (binary ? ".bin" : ".txt"))).string();
  if (!Exists(path)) return {};
  const FileBytes file(path);
  return (binary ? parse_binary : parse_text)(file.view(), path);
}

CameraModel ReadColmap(const fs::path& folder, bool binary) {
  CameraModel model;
  model.format = "colmap";
  const auto focal_lengths =
      ReadOptional(folder, "cameras", binary, ParseColmapCameras, ParseColmapCamerasBinary);
  const std::string path = (folder / (binary ? "images.bin" : "images.txt")).string();
  const FileBytes images(path);
  model.cameras =
      (binary ? ParseColmapImagesBinary : ParseColmapImages)(images.view(), focal_lengths, path);
  model.points =
      ReadOptional(folder, "points3D", binary, ParseColmapPoints, ParseColmapPointsBinary);
  return model;
}

CameraModel ReadColmapFolder(const std::string& folder) {
  for (const bool binary : {true, false}) {
    if (Exists(fs::path(folder) / (binary ? "images.bin" : "images.txt"))) {
      return ReadColmap(folder, binary);
    }
  }
  throw InputError::InFile(folder, "is a folder without images.bin and images.txt (COLMAP)");
}

// Bundler keeps the images' names in a list beside its result, one a line.
void AddBundlerNames(const fs::path& path, CameraModel* model) {
  const std::string list = (path.parent_path() / "list.txt").string();
  if (model->format != "bundler" || !Exists(list)) return;
  const FileBytes file(list);
  std::vector<std::string> names;
  LineReader lines(file.view());
  std::string_view line;
  while (lines.Next(&line)) {
    const auto words = SplitWords(line);
    if (!words.empty()) names.emplace_back(words.front());
  }
  if (names.size() != model->cameras.size()) return;  // the list of something else
  for (std::size_t i = 0; i < names.size(); ++i) model->cameras[i].image = names[i];
}

// The files of a COLMAP model stand for the folder.
bool IsColmapFile(const fs::path& path) {
  const std::string stem = path.stem().string(), ending = path.extension().string();
  const bool name = stem == "images" || stem == "cameras" || stem == "points3D";
  return name && (ending == ".txt" || ending == ".bin");
}

CameraModel ReadAnyCameras(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return ReadColmapFolder(path);
  if (IsColmapFile(path) && Exists(path)) {
    return ReadColmap(fs::path(path).parent_path(), fs::path(path).extension() == ".bin");
  }
  const FileBytes file(path);
  const std::size_t first = file.view().find_first_not_of(" \t\r\n");
  const bool json = first != std::string_view::npos && file.view()[first] == '[';
  if (json) return ParseOpenSfm(file.view(), path);
  CameraModel model = ParseBundle(file.view(), path);
  AddBundlerNames(path, &model);
  return model;
}

}  // namespace

CameraModel ReadCameras(const std::string& path) {
  CameraModel model = ReadAnyCameras(path);
  if (model.cameras.empty()) throw InputError::InFile(path, "holds no camera");
  return model;
}

}  // namespace planegraph
