#include "io/csv_table.h"

#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view WithoutMark(std::string_view bytes) {
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
  return bytes;
}

char HeaderSeparator(std::string_view header) {
  for (const char separator : {';', ',', '\t'}) {
    if (header.find(separator) != header.npos) return separator;
  }
  return ' ';
}

}  // namespace

CsvTable::CsvTable(std::string_view bytes, std::string file)
    : file_(std::move(file)), lines_(WithoutMark(bytes)) {
  std::string_view header;
  if (!NextLine(&header)) throw InputError::InFile(file_, "is empty");
  separator_ = HeaderSeparator(header);
  for (const auto& name : SplitFields(header, separator_)) names_.push_back(ToLower(Trim(name)));
}

std::size_t CsvTable::Column(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
  }
  return kNone;
}

std::size_t CsvTable::RequiredColumn(const std::vector<std::string>& names) const {
  const std::size_t column = Column(names);
  if (column == kNone) Fail("the first line names no column `" + names.front() + "`");
  return column;
}

bool CsvTable::NextRow() {
  std::string_view line;
  if (!NextLine(&line)) return false;
  fields_ = SplitFields(line, separator_);
  return true;
}

std::string_view CsvTable::Field(std::size_t column) const {
  return column < fields_.size() ? fields_[column] : std::string_view();
}

double CsvTable::Number(std::size_t column) const {
  double value = 0.0;
  if (!ParseNumber(Field(column), &value) || !std::isfinite(value)) {
    Fail(names_[column] + " is not a finite number: " + Excerpt(Field(column)));
  }
  return value;
}

void CsvTable::Fail(const std::string& reason) const {
  throw InputError::AtLine(file_, lines_.number(), reason);
}

bool CsvTable::NextLine(std::string_view* line) {
  while (lines_.Next(line)) {
    const std::string_view trimmed = Trim(*line);
    if (!trimmed.empty() && trimmed.front() != '#') return true;
  }
  return false;
}

}  // namespace planegraph
