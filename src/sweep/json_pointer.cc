#include "sweep/json_pointer.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

// The steps between the slashes; ~1 stands for a slash in a name, ~0 for a tilde.
std::vector<std::string> Steps(const std::string& pointer) {
  std::vector<std::string> steps;
  for (std::size_t i = 0; i < pointer.size(); ++i) {
    const bool escaped = pointer[i] == '~' && i + 1 < pointer.size();
    if (pointer[i] == '/') {
      steps.emplace_back();
    } else if (escaped) {
      steps.back() += pointer[++i] == '1' ? '/' : '~';
    } else {
      steps.back() += pointer[i];
    }
  }
  return steps;
}

bool IsIndex(const std::string& step) {
  return !step.empty() && step.size() < 10 &&
         step.find_first_not_of("0123456789") == std::string::npos;
}

void Follow(const Json& node, const std::vector<std::string>& steps, std::size_t at,
            std::vector<Json>* found) {
  if (at == steps.size()) return found->push_back(node);
  const std::string& step = steps[at];
  if (step == "*" && node.is_structured()) {
    for (const Json& member : node) Follow(member, steps, at + 1, found);
  } else if (node.is_object() && node.contains(step)) {
    Follow(node[step], steps, at + 1, found);
  } else if (node.is_array() && IsIndex(step) && std::stoul(step) < node.size()) {
    Follow(node[std::stoul(step)], steps, at + 1, found);
  }
}

}  // namespace

std::vector<Json> FollowPointer(const Json& root, const std::string& pointer) {
  std::vector<Json> found;
  Follow(root, Steps(pointer), 0, &found);
  return found;
}

}  // namespace planegraph
