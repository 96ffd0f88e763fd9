// json_table COLUMNS LABELS ROW...: a Markdown table of values in JSON files.
//
// COLUMNS is a file with a line for each column, fields parted by tabs: heading, file, key (parted
// by dots; a number is a place in an array), decimals, factor. LABELS are the headings of the
// labels, parted by `|`. A ROW is `LABEL=FOLDER[,FOLDER...]`, `LABEL=!REASON` for what was skipped,
// or `LABEL=|CELL|CELL...` for figures from elsewhere; a label has as many parts as LABELS.
// Several values, of an array or of several folders, are shown as `median [least to greatest]`. A
// heading that starts with `?` is that of an interval of two numbers, shown as `low to high`; the
// column is left out where no row has one.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using nlohmann::json;

constexpr const char* kNone = "&ndash;";

struct Column {
  std::string heading, file, key;
  int decimals = 3;
  double factor = 1.0;
};

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

Column ParseColumn(const std::string& line, const std::string& file, std::size_t number) {
  const auto fields = Split(line, '\t');
  if (fields.size() != 5) throw InputError::AtLine(file, number, "five fields are expected");
  try {
    return {fields[0], fields[1], fields[2], std::stoi(fields[3]), std::stod(fields[4])};
  } catch (const std::exception&) {
    throw InputError::AtLine(file, number, "decimals and factor must be numbers");
  }
}

std::vector<Column> ReadColumns(const std::string& file) {
  std::vector<Column> columns;
  std::size_t number = 0;
  for (const std::string& line : Split(ReadTextFile(file), '\n')) {
    ++number;
    if (!line.empty() && line[0] != '#') columns.push_back(ParseColumn(line, file, number));
  }
  return columns;
}

// The value at `key`; null where there is none.
json ValueAt(json value, const std::string& key) {
  for (const std::string& part : Split(key, '.')) {
    if (value.is_array()) {
      const std::size_t place = std::stoul(part);
      value = place < value.size() ? json(value[place]) : json();
    } else {
      value = value.is_object() && value.contains(part) ? json(value[part]) : json();
    }
  }
  return value;
}

json ReadJson(const std::string& path) {
  if (!std::filesystem::exists(path)) return {};
  try {
    return json::parse(ReadTextFile(path));
  } catch (const json::parse_error& error) {
    throw InputError::AtByte(path, error.byte, "is not valid JSON");
  }
}

std::string Number(double value, const Column& column) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", column.decimals, value * column.factor);
  return text;
}

bool IsInterval(const Column& column) { return column.heading[0] == '?'; }

// The interval at the column's key; empty where there is none, or not one alone.
std::string Interval(const Column& column, const std::vector<std::string>& folders) {
  const json value = ValueAt(ReadJson(folders[0] + "/" + column.file), column.key);
  const bool known = folders.size() == 1 && value.is_array() && value.size() == 2 &&
                     value[0].is_number() && value[1].is_number();
  return known ? Number(value[0], column) + " to " + Number(value[1], column) : "";
}

std::string Spread(std::vector<double> values, const Column& column) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  const double median =
      values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
  if (values.size() == 1) return Number(median, column);
  return Number(median, column) + " [" + Number(values.front(), column) + " to " +
         Number(values.back(), column) + "]";
}

std::string Cell(const Column& column, const std::vector<std::string>& folders) {
  std::vector<double> numbers;
  std::string text;
  if (IsInterval(column)) {
    text = Interval(column, folders);
    return text.empty() ? kNone : text;
  }
  for (const std::string& folder : folders) {
    json value = ValueAt(ReadJson(folder + "/" + column.file), column.key);
    if (!value.is_array()) value = json::array({value});
    for (const json& one : value) {
      if (one.is_number()) numbers.push_back(one.get<double>());
      if (one.is_boolean()) text += one.get<bool>() ? "yes" : "no";
      if (one.is_string()) text += (text.empty() ? "" : ", ") + one.get<std::string>();
    }
  }
  if (!numbers.empty()) return Spread(numbers, column);
  return text.empty() ? kNone : text;
}

std::vector<std::string> Cells(const std::string& content, const std::vector<Column>& columns) {
  std::vector<std::string> cells;
  if (content[0] == '!') cells = {"*skipped: " + content.substr(1) + "*"};
  if (content[0] == '|') cells = Split(content.substr(1), '|');
  if (cells.empty()) {
    for (const Column& column : columns) cells.push_back(Cell(column, Split(content, ',')));
  }
  cells.resize(columns.size());
  return cells;
}

void PrintLine(const std::vector<std::string>& labels, const std::vector<std::string>& cells) {
  std::printf("|");
  for (const std::string& label : labels) std::printf(" %s |", label.c_str());
  for (const std::string& cell : cells) std::printf(" %s |", cell.c_str());
  std::printf("\n");
}

// The content of a row, behind its label. Throws UsageError.
std::size_t ContentOf(const std::string& row) {
  const std::size_t equals = row.find('=');
  if (equals == std::string::npos || equals + 1 == row.size()) {
    throw UsageError("a row is LABEL=FOLDER, LABEL=!REASON or LABEL=|CELL|CELL, not " + row);
  }
  return equals + 1;
}

void PrintRow(const std::string& row, const std::vector<Column>& columns) {
  const std::size_t content = ContentOf(row);
  PrintLine(Split(row.substr(0, content - 1), '|'), Cells(row.substr(content), columns));
}

// The columns without the intervals that no row has, and without the marks of the others.
std::vector<Column> UsedColumns(std::vector<Column> columns, const std::vector<std::string>& rows) {
  std::erase_if(columns, [&](const Column& column) {
    return IsInterval(column) && std::all_of(rows.begin(), rows.end(), [&](const auto& row) {
             const std::string content = row.substr(ContentOf(row));
             return content[0] == '!' || content[0] == '|' ||
                    Interval(column, Split(content, ',')).empty();
           });
  });
  return columns;
}

std::string Heading(const Column& column) { return column.heading.substr(IsInterval(column)); }

int Run(const std::vector<std::string>& arguments) {
  if (arguments.size() < 3) throw UsageError("json_table COLUMNS LABELS ROW...");
  const std::vector<std::string> rows(arguments.begin() + 2, arguments.end());
  const auto columns = UsedColumns(ReadColumns(arguments[0]), rows);
  std::vector<std::string> headings;
  for (const Column& column : columns) headings.push_back(Heading(column));
  const auto labels = Split(arguments[1], '|');
  PrintLine(labels, headings);
  std::printf("|");
  for (std::size_t k = 0; k < labels.size() + columns.size(); ++k) std::printf("---|");
  std::printf("\n");
  for (const std::string& row : rows) PrintRow(row, columns);
  return 0;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  try {
    return planegraph::Run({argv + 1, argv + argc});
  } catch (const planegraph::UsageError& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  }
}
