#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

// What it does not agree with; names may be many.
std::string Contradicted(const Json& off) {
  std::string names;
  for (const Json& name : ListAt(off, {"contradicts"})) {
    if (name.is_string()) names += (names.empty() ? "" : ", ") + Escape(name.get<std::string>());
  }
  return names.empty() ? "" : "contradicted: " + names;
}

}  // namespace

std::string SwitchedOffHtml(const ReportData& data) {
  HtmlTable table({{"target", "", false},
                   {"source", "", false},
                   {"kind", "", false},
                   {"by", "", false},
                   {"weight", ""},
                   {"off by", "sigmas"},
                   {"of at most", "sigmas"}});
  for (const Json& off : ListAt(*data.json, {"switched_off"})) {
    table.Row({TextOrDash(TextAt(off, {"target"})), TextOrDash(TextAt(off, {"source"})),
               TextOrDash(TextAt(off, {"kind"})), TextOrDash(TextAt(off, {"by"})),
               FixedOrDash(NumberAt(off, {"weight"}), 3), FixedOrDash(NumberAt(off, {"sigmas"}), 1),
               FixedOrDash(NumberAt(off, {"threshold_sigmas"}), 1)});
    const std::string reason = Escape(TextAt(off, {"reason"})), others = Contradicted(off);
    table.Note(reason + (reason.empty() || others.empty() ? "" : "; ") + others);
  }
  if (table.rows() == 0) return "";
  return Section(
      "Switched off",
      "<p class=\"note\">Registrations and measurements that contradict the others and "
      "take no part in the map.</p>\n" +
          table.Html("Table of all " + std::to_string(table.rows()) + " that were switched off"));
}

}  // namespace planegraph
