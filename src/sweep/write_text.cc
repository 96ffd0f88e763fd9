// The table for papers (LaTeX) and for pages of documentation (Markdown).
#include "sweep/writers.h"

namespace planegraph {
namespace {

std::string EscapeLatex(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string("_&%#${}").find(c) != std::string::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

// A number in mathematical mode, where minus is a minus.
std::string Math(const std::string& number) { return "$" + number + "$"; }

std::string LatexCell(const CellText& text) {
  if (text.value.empty()) return "--";
  std::string cell = Math(text.value + (text.is_significant ? "^{*}" : ""));
  if (!text.interval.empty()) cell += " {\\scriptsize[" + Math(text.interval) + "]}";
  return cell;
}

std::string MarkdownCell(const CellText& text) {
  if (text.value.empty()) return "–";
  std::string cell = text.is_significant ? "**" + text.value + "**" : text.value;
  if (!text.interval.empty()) cell += " [" + text.interval + "]";
  std::string compared = text.absolute.empty() ? text.change : text.absolute;
  if (!text.p.empty()) compared += (compared.empty() ? "p " : ", p ") + text.p;
  return compared.empty() ? cell : cell + " (" + compared + ")";
}

std::string SuccessText(const SweepRow& row) {
  return std::to_string(row.succeeded) + " of " + std::to_string(row.runs);
}

// The same data set is named once.
std::string NameOrBlank(const SweepContent& content, std::size_t row) {
  const bool repeats = row > 0 && content.rows[row].data_set == content.rows[row - 1].data_set;
  return repeats ? "" : content.rows[row].data_set;
}

}  // namespace

std::string TableLatex(const SweepContent& content) {
  const Experiment& experiment = content.experiment;
  std::string text = "% " + experiment.name + "\n";
  for (const std::string& note : NotesOf(content)) text += "% " + note + "\n";
  text += "% A star: p at or below 1 - level.\n\\begin{tabular}{llr";
  text += std::string(experiment.metrics.size(), 'r') + "}\n\\hline\ndata set & variant & runs";
  for (const SweepMetric& metric : experiment.metrics) {
    const std::string unit = UnitOf(metric);
    text += " & " + EscapeLatex(metric.name + (unit.empty() ? "" : " [" + unit + "]"));
  }
  text += " \\\\\n";
  for (std::size_t r = 0; r < content.rows.size(); ++r) {
    const std::string name = NameOrBlank(content, r);
    if (!name.empty()) text += "\\hline\n";
    text += EscapeLatex(name) + " & " + EscapeLatex(content.rows[r].variant) + " & " +
            SuccessText(content.rows[r]);
    for (std::size_t m = 0; m < experiment.metrics.size(); ++m) {
      text += " & " + LatexCell(TextOf(content, content.rows[r], m));
    }
    text += " \\\\\n";
  }
  return text + "\\hline\n\\end{tabular}\n";
}

std::string TableMarkdown(const SweepContent& content) {
  const Experiment& experiment = content.experiment;
  std::string head = "| data set | variant | succeeded |", rule = "|---|---|---|";
  for (const SweepMetric& metric : experiment.metrics) {
    const std::string unit = UnitOf(metric);
    head += " " + metric.name + (unit.empty() ? "" : ", " + unit) + " |";
    rule += "---|";
  }
  std::string text = head + "\n" + rule + "\n";
  for (std::size_t r = 0; r < content.rows.size(); ++r) {
    const SweepRow& row = content.rows[r];
    text += "| " + NameOrBlank(content, r) + " | " + row.variant +
            (row.is_baseline ? " (baseline)" : "") + " | " + SuccessText(row) + " |";
    for (std::size_t m = 0; m < experiment.metrics.size(); ++m) {
      text += " " + MarkdownCell(TextOf(content, row, m)) + " |";
    }
    text += "\n";
  }
  return text;
}

}  // namespace planegraph
