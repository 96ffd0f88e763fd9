// `planegraph factors`: the cost variants that there are.
#include <iostream>

#include "planegraph/graph/factor_registry.h"
#include "tools/command.h"

namespace planegraph::tools {
namespace {

nlohmann::json ToJson(const FactorParameter& parameter) {
  nlohmann::json json = {{"name", parameter.name},
                         {"unit", parameter.unit},
                         {"description", parameter.description},
                         {"field", parameter.is_field}};
  if (!parameter.is_field) json["default"] = parameter.default_value;
  return json;
}

nlohmann::json ToJson(const FactorType& type) {
  nlohmann::json parameters = nlohmann::json::array();
  for (const FactorParameter& parameter : type.parameters) parameters.push_back(ToJson(parameter));
  return {{"name", type.name},
          {"kind", ToString(type.kind)},
          {"description", type.description},
          {"residual", type.residual},
          {"source", type.source},
          {"plane_blocks", type.plane_blocks},
          {"parameters", parameters}};
}

void Print(const FactorType& type) {
  std::cout << type.name << " (" << ToString(type.kind) << "): " << type.description
            << "\n  residual: " << type.residual << "\n  source: " << type.source << "\n";
  for (const FactorParameter& parameter : type.parameters) {
    std::cout << "  " << parameter.name << " [" << parameter.unit << "]: " << parameter.description;
    if (!parameter.is_field) std::cout << " (default " << parameter.default_value << ")";
    std::cout << "\n";
  }
}

int RunFactors(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 0, 0);
  nlohmann::json factors = nlohmann::json::array();
  for (const auto& [name, type] : BuiltinFactors().types()) {
    factors.push_back(ToJson(type));
    if (WantsText()) Print(type);
  }
  EmitResult({{"factors", factors}}, false);
  return 0;
}

}  // namespace

Command FactorsCommand() {
  return {
      "factors", "", "the cost variants, with their parameters, units and sources", {}, RunFactors};
}

}  // namespace planegraph::tools
