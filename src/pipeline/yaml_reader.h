#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <set>
#include <string>

#include "planegraph/base/error.h"

namespace planegraph {

/// Reads nodes of one YAML file; every complaint is an InputError that names its line. Paths in the
/// file are relative to `folder`.
class YamlReader {
 public:
  YamlReader(std::string path, std::filesystem::path folder)
      : path_(std::move(path)), folder_(std::move(folder)) {}
  explicit YamlReader(const std::string& path)
      : YamlReader(path, std::filesystem::path(path).parent_path()) {}

 protected:
  static std::size_t Line(const YAML::Node& node) {
    return static_cast<std::size_t>(node.Mark().line + 1);
  }
  [[noreturn]] void Fail(const YAML::Node& node, const std::string& reason) const {
    throw InputError::AtLine(path_, Line(node), reason);
  }
  /// The file's root.
  YAML::Node Load() const;
  /// Refuses what is no map, and keys of it other than these.
  void AllowKeys(const YAML::Node& map, const std::set<std::string>& keys) const;
  /// The value of a node; `what` names it in the complaint.
  template <typename T>
  T Value(const YAML::Node& node, const std::string& what) const {
    try {
      return node.as<T>();
    } catch (const YAML::Exception&) {
      Fail(node, what + " is not of the right kind");
    }
  }
  std::string Text(const YAML::Node& map, const std::string& key,
                   const std::string& fallback) const;
  /// The path of a file or folder that exists, empty where the key is absent.
  std::string File(const YAML::Node& map, const std::string& key) const;

  std::string path_;
  std::filesystem::path folder_;
};

}  // namespace planegraph
