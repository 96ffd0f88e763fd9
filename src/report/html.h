#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace planegraph {

/// `text` with the characters that mean something in HTML replaced, for text and quoted attributes.
std::string Escape(std::string_view text);

/// What stands where a value is missing.
inline constexpr const char* kDash = "–";

/// A number with a fixed number of decimals, whatever the locale.
std::string Fixed(double value, int decimals);
/// The same times `factor`, or the dash.
std::string FixedOrDash(const std::optional<double>& value, int decimals, double factor = 1.0);
/// About `digits` significant digits, without an exponent where that is readable.
std::string Significant(double value, int digits);
std::string SignificantOrDash(const std::optional<double>& value, int digits);
/// The shortest form.
std::string PlainOrDash(const std::optional<double>& value);
/// A whole number in groups of three digits.
std::string Grouped(double value);
std::string GroupedOrDash(const std::optional<double>& value);
/// Escaped text, or the dash where it is empty.
std::string TextOrDash(std::string_view text);

/// A column of a table: numbers stand at the right, with their unit in the head.
struct HtmlColumn {
  std::string title, unit;
  bool numeric = true;
};

/// A table, row by row. Cells are HTML.
class HtmlTable {
 public:
  explicit HtmlTable(std::vector<HtmlColumn> columns) : columns_(std::move(columns)) {}
  /// `attributes`: further ones of the row, with a blank before each.
  void Row(const std::vector<std::string>& cells, std::string_view row_class = "",
           std::string_view attributes = "");
  /// A second line of the last row, over its whole width; HTML, nothing where it is empty.
  void Note(const std::string& note);
  std::size_t rows() const { return rows_; }
  /// The table; folded up behind `summary` where it has more rows than `most_open`.
  std::string Html(const std::string& summary, std::size_t most_open = 16) const;

 private:
  std::string Head() const;

  std::vector<HtmlColumn> columns_;
  std::string body_, row_class_;
  std::size_t rows_ = 0;
};

/// What the 3-D view is asked for by a row: the `index`-th scan or registration, by `kind`.
std::string ViewAttribute(const char* kind, std::size_t index);

/// A section with its heading; empty where there is no content.
std::string Section(const std::string& title, const std::string& content);

}  // namespace planegraph
