#include "planegraph/graph/factor_losses.h"

#include <sstream>

#include "planegraph/base/error.h"

namespace planegraph {

std::string FactorLosses::ToString() const {
  std::string text = general.ToString();
  for (const auto& [type, loss] : by_type) text.append(",").append(type + "=" + loss.ToString());
  return text;
}

FactorLosses ParseFactorLosses(const std::string& text, const LossSpec& general,
                               const FactorRegistry& factors) {
  FactorLosses losses{general, {}};
  if (!text.empty() && text.back() == ',') throw UsageError("a loss is missing after the comma");
  std::istringstream list(text);
  bool first = true;
  for (std::string item; std::getline(list, item, ',') || first; first = false) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos) {
      if (!first) throw UsageError("'" + item + "' among the losses is not FACTOR=LOSS");
      losses.general = ParseLoss(item);
      continue;
    }
    const std::string type = item.substr(0, equals);
    if (!losses.by_type.emplace(type, ParseLoss(item.substr(equals + 1))).second) {
      throw UsageError("the factor '" + type + "' has two losses");
    }
  }
  CheckFactorNames(losses.by_type, factors);
  return losses;
}

void CheckFactorNames(const std::map<std::string, LossSpec>& by_type,
                      const FactorRegistry& factors) {
  const auto& types = factors.types();
  for (const auto& entry : by_type) {
    if (types.count(entry.first)) continue;
    std::string names;
    for (const auto& type : types) names.append(names.empty() ? "" : ", ").append(type.first);
    throw UsageError("a loss for the unknown factor '" + entry.first + "' (there are: " + names +
                     ")");
  }
}

}  // namespace planegraph
