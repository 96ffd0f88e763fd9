#pragma once

#include <charconv>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace planegraph {

/// Walks the lines of a text in memory; counts them from `first_number`. A carriage return before
/// the line feed is not part of the line.
class LineReader {
 public:
  explicit LineReader(std::string_view text, std::size_t first_number = 1)
      : text_(text), number_(first_number - 1) {}

  bool Next(std::string_view* line) {
    if (position_ >= text_.size()) return false;
    const char* begin = text_.data() + position_;
    const std::size_t left = text_.size() - position_;
    const void* feed = std::memchr(begin, '\n', left);
    std::size_t length =
        feed ? static_cast<std::size_t>(static_cast<const char*>(feed) - begin) : left;
    position_ += length + (feed ? 1 : 0);
    if (length > 0 && begin[length - 1] == '\r') --length;
    *line = {begin, length};
    ++number_;
    return true;
  }
  /// Number of the line that Next gave last.
  std::size_t number() const { return number_; }
  /// First byte behind that line.
  std::size_t position() const { return position_; }

 private:
  std::string_view text_;
  std::size_t position_ = 0, number_;
};

inline bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

/// Without the blanks at both ends.
std::string_view Trim(std::string_view text);
/// The words between blanks.
std::vector<std::string_view> SplitWords(std::string_view line);
std::string ToLower(std::string_view text);
/// The start of `text`, fit for an error message: printable and short.
std::string Excerpt(std::string_view text);
/// The whole of `text` as a number; false where it is none.
bool ParseNumber(std::string_view text, double* value);
bool ParseInteger(std::string_view text, long long* value);

/// Takes the fields of one line from left to right. With `separator` ' ' fields are parted by runs
/// of blanks, else by exactly one separator (so that a field may be empty), blanks around it
/// ignored.
class FieldReader {
 public:
  FieldReader(std::string_view line, char separator)
      : at_(line.data()), end_(line.data() + line.size()), separator_(separator) {}

  /// The next field as a number. `kEnd`: no field left; `kOther`: not a number (or empty).
  enum class Result { kNumber, kOther, kEnd };
  Result Next(double* value) {
    SkipBlanks();
    if (at_ == end_) return Result::kEnd;
    const char* start = at_ + (*at_ == '+' ? 1 : 0);
    const auto [stop, error] = std::from_chars(start, end_, *value);
    if (error == std::errc() && EndsAt(stop)) return Result::kNumber;
    return NextUnusual(value);
  }

 private:
  void SkipBlanks() {
    while (at_ != end_ && IsBlank(*at_)) ++at_;
  }
  // Moves behind the field (and its separator) where one ends at `stop`.
  bool EndsAt(const char* stop) {
    const char* before = stop;
    while (stop != end_ && IsBlank(*stop)) ++stop;
    if (separator_ != ' ' && stop != end_) {
      if (*stop != separator_) return false;
      ++stop;
    } else if (stop == before && stop != end_) {
      return false;
    }
    at_ = stop;
    return true;
  }
  Result NextUnusual(double* value);

  const char* at_;
  const char* end_;
  char separator_;
};

/// The separator of a line of numbers: ';' or ',' where one occurs, else ' '.
char SeparatorOf(std::string_view line);
/// The fields of a line as text, without quotes and blanks around.
std::vector<std::string_view> SplitFields(std::string_view line, char separator);

/// Appends the shortest text that reads back as the same number.
void AppendNumber(std::string* text, double value);
void AppendNumber(std::string* text, float value);
void AppendNumber(std::string* text, long long value);

}  // namespace planegraph
