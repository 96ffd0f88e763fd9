#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/text_scanner.h"

namespace planegraph {

/// Walks the rows of a text table whose first line names the columns. The separator is that of the
/// header: `;`, `,`, a tab, or blanks. Empty lines and lines that start with # are passed over.
class CsvTable {
 public:
  /// Throws InputError where there is no header.
  CsvTable(std::string_view bytes, std::string file);

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  /// The first column with one of the names (lower case); kNone where there is none.
  std::size_t Column(const std::vector<std::string>& names) const;
  /// The same, where absence is an InputError.
  std::size_t RequiredColumn(const std::vector<std::string>& names) const;

  bool NextRow();
  /// The field of the row; empty where the row is too short or the column is kNone.
  std::string_view Field(std::size_t column) const;
  /// The field as a finite number. Throws InputError.
  double Number(std::size_t column) const;
  [[noreturn]] void Fail(const std::string& reason) const;

 private:
  bool NextLine(std::string_view* line);

  std::string file_;
  LineReader lines_;
  char separator_ = ',';
  std::vector<std::string> names_;
  std::vector<std::string_view> fields_;
};

}  // namespace planegraph
