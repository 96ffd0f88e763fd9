#include "io/text_scanner.h"

#include <algorithm>
#include <cctype>
#include <limits>

namespace planegraph {
namespace {

template <typename T>
bool ParseWhole(std::string_view text, T* value) {
  text = Trim(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, *value);
  return error == std::errc() && stop == end && !text.empty();
}

template <typename T>
void Append(std::string* text, T value) {
  char buffer[40];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof(buffer), value);
  text->append(buffer, end);
}

}  // namespace

std::string_view Trim(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> SplitWords(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while (true) {
    while (at < line.size() && IsBlank(line[at])) ++at;
    if (at == line.size()) return words;
    const std::size_t begin = at;
    while (at < line.size() && !IsBlank(line[at])) ++at;
    words.push_back(line.substr(begin, at - begin));
  }
}

std::string ToLower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::string Excerpt(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string excerpt(text.substr(0, kLongest));
  for (char& c : excerpt) {
    if (!std::isprint(static_cast<unsigned char>(c))) c = '?';
  }
  return "'" + excerpt + (text.size() > kLongest ? "...'" : "'");
}

bool ParseNumber(std::string_view text, double* value) { return ParseWhole(text, value); }
bool ParseInteger(std::string_view text, long long* value) { return ParseWhole(text, value); }

// A field that from_chars does not take as it stands: empty, text, or a number out of double's
// range (a denormal is then 0, and a huge one infinite).
FieldReader::Result FieldReader::NextUnusual(double* value) {
  const char* stop = at_;
  while (stop != end_ && (separator_ == ' ' ? !IsBlank(*stop) : *stop != separator_)) ++stop;
  const std::string_view field = Trim({at_, static_cast<std::size_t>(stop - at_)});
  at_ = stop == end_ || separator_ == ' ' ? stop : stop + 1;
  const char* begin = field.data() + (!field.empty() && field.front() == '+' ? 1 : 0);
  const char* end = field.data() + field.size();
  const auto [after, error] = std::from_chars(begin, end, *value);
  if (error == std::errc::result_out_of_range && after == end) {
    const bool tiny = field.find("e-") != field.npos || field.find("E-") != field.npos;
    *value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
    return Result::kNumber;
  }
  *value = std::numeric_limits<double>::quiet_NaN();
  return Result::kOther;
}

char SeparatorOf(std::string_view line) {
  if (line.find(';') != line.npos) return ';';
  return line.find(',') != line.npos ? ',' : ' ';
}

std::vector<std::string_view> SplitFields(std::string_view line, char separator) {
  if (separator == ' ') return SplitWords(line);
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t length = std::min(line.find(separator), line.size());
    std::string_view field = Trim(line.substr(0, length));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
      field = field.substr(1, field.size() - 2);
    }
    fields.push_back(field);
    if (length == line.size()) return fields;
    line.remove_prefix(length + 1);
  }
}

void AppendNumber(std::string* text, double value) { Append(text, value); }
void AppendNumber(std::string* text, float value) { Append(text, value); }
void AppendNumber(std::string* text, long long value) { Append(text, value); }

}  // namespace planegraph
