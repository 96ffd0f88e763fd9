#include "pipeline/yaml_reader.h"

#include <algorithm>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/nearest_name.h"

namespace planegraph {

YAML::Node YamlReader::Load() const {
  const std::string text = ReadTextFile(path_);
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError::AtLine(path_, static_cast<std::size_t>(std::max(error.mark.line, 0)) + 1,
                             "is not valid YAML: " + error.msg);
  }
}

void YamlReader::AllowKeys(const YAML::Node& map, const std::set<std::string>& keys) const {
  if (!map.IsMap()) Fail(map, "expected `key: value` entries");
  for (const auto& entry : map) {
    const auto key = entry.first.as<std::string>("");
    if (keys.count(key)) continue;
    std::string known;
    for (const auto& k : keys) known += (known.empty() ? "" : ", ") + k;
    const std::string near = NearestName(key, {keys.begin(), keys.end()});
    const std::string advice = near.empty() ? "" : "; did you mean " + near + "?";
    Fail(entry.first, "unknown key '" + key + "' (known here: " + known + ")" + advice);
  }
}

std::string YamlReader::Text(const YAML::Node& map, const std::string& key,
                             const std::string& fallback) const {
  return map[key] ? Value<std::string>(map[key], key) : fallback;
}

std::string YamlReader::File(const YAML::Node& map, const std::string& key) const {
  if (!map[key]) return "";
  const std::filesystem::path file = folder_ / Value<std::string>(map[key], key);
  if (!std::filesystem::exists(file)) Fail(map[key], key + ": there is no " + file.string());
  return file.string();
}

}  // namespace planegraph
