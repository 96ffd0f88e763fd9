#include "report/html.h"
#include "report/sections.h"

namespace planegraph {
namespace {

std::string CorrespondencesText(const Json& r) {
  const Json& value = Get(r, {"correspondences"});
  if (value.is_array()) return Grouped(static_cast<double>(value.size()));
  return GroupedOrDash(NumberAt(r, {"correspondences"}));
}

// The direction that a registration knows least of, with its standard deviation.
std::string WeakestOf(const Json& r) {
  constexpr double kUnheld = 100.0;  // metres: beyond, nothing but the solver's damping holds it
  const auto covariance = CovarianceOf(r);
  if (!covariance) return kDash;
  const Weakest weakest = WeakestAxis(*covariance, 0);
  std::string axis;  // in one piece, wherever the line breaks
  for (int k = 0; k < 3; ++k) axis += (k > 0 ? ",\u00a0" : "") + Fixed(weakest.axis[k], 1);
  return (weakest.sigma < kUnheld ? Fixed(1000.0 * weakest.sigma, 1) + "\u00a0mm" : "open") +
         " along (" + axis + ")";
}

// Why it is not used, and what it leaves open: the reason of a degenerate one names that already.
std::string NoteText(const Json& r) {
  std::string note = Escape(TextAt(r, {"reason"}));
  if (!note.empty() && TextAt(r, {"status"}) == "degenerate") return note;
  for (const OpenDirection& open : OpenDirections(r)) {
    note += (note.empty() ? "" : "; ") + InWords(open) + " not observed";
  }
  return note;
}

std::string StatusText(const std::string& status) {
  if (status.empty()) return kDash;
  return "<span class=\"status " + std::string(status == "ok" ? "good" : "fair") + "\">" +
         Escape(status) + "</span>";
}

std::string UsedText(const std::optional<bool>& used) {
  if (!used) return kDash;
  return *used ? "yes" : "no";
}

void AddRegistration(const Json& r, HtmlTable* table) {
  table->Row({TextOrDash(TextAt(r, {"target"})), TextOrDash(TextAt(r, {"source"})),
              TextOrDash(TextAt(r, {"kind"})), StatusText(TextAt(r, {"status"})),
              UsedText(FlagAt(r, {"used"})), CorrespondencesText(r),
              GroupedOrDash(NumberAt(r, {"surfels"})), FixedOrDash(NumberAt(r, {"rms"}), 1, 1000.0),
              FixedOrDash(NumberAt(r, {"tilt_rms"}), 2, 1000.0),
              GroupedOrDash(NumberAt(r, {"redundancy"})), FixedOrDash(NumberAt(r, {"quality"}), 2),
              FixedOrDash(NumberAt(r, {"seconds"}), 3), WeakestOf(r)},
             FlagAt(r, {"used"}).value_or(true) ? "" : "unused",
             ViewAttribute("registration", table->rows()));
  table->Note(NoteText(r));
}

}  // namespace

// Each with a second line where there is something to explain.
std::string RegistrationsHtml(const ReportData& data) {
  HtmlTable table({{"target", "", false},
                   {"source", "", false},
                   {"kind", "", false},
                   {"status", "", false},
                   {"used", "", false},
                   {"pairs of planes", ""},
                   {"of patches", ""},
                   {"residual", "mm"},
                   {"tilt", "mrad"},
                   {"redundancy", ""},
                   {"quality", ""},
                   {"time", "s"},
                   {"weakest direction", "", false}});
  for (const Json& r : ListAt(*data.json, {"registrations"})) AddRegistration(r, &table);
  return table.Html("Table of all " + std::to_string(table.rows()) + " registrations");
}

}  // namespace planegraph
