#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

std::string Contradicted(const Json& off) {
  std::string names;
  for (const Json& name : ListAt(off, {"contradicts"})) {
    if (name.is_string()) names += (names.empty() ? "" : ", ") + Escape(name.get<std::string>());
  }
  return names.empty() ? kDash : names;
}

}  // namespace

std::string SwitchedOffHtml(const ReportData& data) {
  HtmlTable table({{"target", "", false},
                   {"source", "", false},
                   {"kind", "", false},
                   {"by", "", false},
                   {"weight", ""},
                   {"off by", "sigmas"},
                   {"of at most", "sigmas"},
                   {"contradicts", "", false},
                   {"why", "", false}});
  for (const Json& off : ListAt(*data.json, {"switched_off"})) {
    table.Row({TextOrDash(TextAt(off, {"target"})), TextOrDash(TextAt(off, {"source"})),
               TextOrDash(TextAt(off, {"kind"})), TextOrDash(TextAt(off, {"by"})),
               FixedOrDash(NumberAt(off, {"weight"}), 3), FixedOrDash(NumberAt(off, {"sigmas"}), 1),
               FixedOrDash(NumberAt(off, {"threshold_sigmas"}), 1), Contradicted(off),
               Escape(TextAt(off, {"reason"}))});
  }
  if (table.rows() == 0) return "";
  return Section(
      "Switched off",
      "<p class=\"note\">Registrations and measurements that contradict the others and "
      "take no part in the map.</p>\n" +
          table.Html("Table of all " + std::to_string(table.rows()) + " that were switched off"));
}

}  // namespace planegraph
