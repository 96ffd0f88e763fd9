#include "report/html.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace planegraph {
namespace {

std::string EscapeCharacter(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return std::string(1, c);
  }
}

}  // namespace

std::string Escape(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) escaped += EscapeCharacter(c);
  return escaped;
}

std::string Fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "∞";
  char buffer[400];
  const auto end =
      std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::fixed, decimals).ptr;
  std::string text(buffer, end);
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  if (text[0] == '-') text = is_zero ? text.substr(1) : text;
  return text;
}

std::string FixedOrDash(const std::optional<double>& value, int decimals, double factor) {
  return value ? Fixed(*value * factor, decimals) : kDash;
}

std::string Significant(double value, int digits) {
  if (value == 0.0 || !std::isfinite(value)) return Fixed(value, 0);
  const double magnitude = std::floor(std::log10(std::abs(value)));
  if (magnitude < -5 || magnitude > 8) {
    char buffer[64];
    const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value,
                                   std::chars_format::scientific, digits - 1)
                         .ptr;
    return std::string(buffer, end);
  }
  return Fixed(value, std::max(0, digits - 1 - static_cast<int>(magnitude)));
}

std::string SignificantOrDash(const std::optional<double>& value, int digits) {
  return value ? Significant(*value, digits) : kDash;
}

std::string PlainOrDash(const std::optional<double>& value) {
  if (!value) return kDash;
  char buffer[64];
  return std::string(buffer, std::to_chars(buffer, buffer + sizeof(buffer), *value).ptr);
}

std::string Grouped(double value) {
  std::string text = Fixed(value, 0);
  const std::size_t first = text[0] == '-' ? 1 : 0;
  if (!std::isfinite(value)) return text;
  for (std::size_t at = text.size(); at > first + 3;) {
    at -= 3;
    text.insert(at, "\u202f");
  }
  return text;
}

std::string GroupedOrDash(const std::optional<double>& value) {
  return value ? Grouped(*value) : kDash;
}

std::string TextOrDash(std::string_view text) { return text.empty() ? kDash : Escape(text); }

void HtmlTable::Row(const std::vector<std::string>& cells, std::string_view row_class,
                    std::string_view attributes) {
  ++rows_;
  row_class_ = row_class;
  body_ += "<tr";
  if (!row_class.empty()) body_ += " class=\"" + row_class_ + "\"";
  body_ += std::string(attributes) + ">";
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    body_ += columns_[i].numeric ? "<td class=\"n\">" : "<td>";
    body_ += (i < cells.size() && !cells[i].empty() ? cells[i] : kDash) + std::string("</td>");
  }
  body_ += "</tr>\n";
}

void HtmlTable::Note(const std::string& note) {
  if (note.empty()) return;
  body_ += "<tr class=\"more" + (row_class_.empty() ? "" : " " + row_class_) + "\"><td colspan=\"" +
           std::to_string(columns_.size()) + "\"><div>" + note + "</div></td></tr>\n";
}

std::string HtmlTable::Head() const {
  std::string head = "<thead><tr>";
  for (const HtmlColumn& column : columns_) {
    head += column.numeric ? "<th class=\"n\">" : "<th>";
    head += Escape(column.title);
    if (!column.unit.empty()) head += "<br><small>" + Escape(column.unit) + "</small>";
    head += "</th>";
  }
  return head + "</tr></thead>\n";
}

std::string HtmlTable::Html(const std::string& summary, std::size_t most_open) const {
  if (rows_ == 0) return "";
  const std::string table =
      "<div class=\"scroll\"><table>" + Head() + "<tbody>\n" + body_ + "</tbody></table></div>\n";
  if (rows_ <= most_open) return table;
  return "<details><summary>" + Escape(summary) + "</summary>\n" + table + "</details>\n";
}

std::string ViewAttribute(const char* kind, std::size_t index) {
  return std::string(" data-") + kind + "=\"" + std::to_string(index) + "\"";
}

std::string Section(const std::string& title, const std::string& content) {
  if (content.empty()) return "";
  return "<section>\n<h2>" + Escape(title) + "</h2>\n" + content + "</section>\n";
}

}  // namespace planegraph
