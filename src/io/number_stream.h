#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {

/// Takes numbers parted by blanks and line feeds from a text, from left to right. Throws InputError
/// with the line.
class NumberStream {
 public:
  NumberStream(std::string_view text, std::string file, std::size_t first_line)
      : text_(text), file_(std::move(file)), line_(first_line) {}

  std::size_t line() const { return line_; }
  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError::AtLine(file_, line_, reason);
  }
  double Number() {
    double value = 0.0;
    const std::string_view word = Word();
    if (!ParseNumber(word, &value) || !std::isfinite(value)) {
      Fail("is not a finite number: " + Excerpt(word));
    }
    return value;
  }
  /// A count of things that take at least `numbers` numbers each: more than the rest of the text
  /// can hold is an error.
  std::size_t Count(std::size_t numbers, const std::string& what) {
    const std::string_view word = Word();
    long long count = 0;
    if (!ParseInteger(word, &count) || count < 0) {
      Fail("is no number of " + what + ": " + Excerpt(word));
    }
    const std::size_t most = (text_.size() + 1) / 2 / numbers;  // a digit and a blank each
    if (static_cast<std::uint64_t>(count) > most) {
      Fail(std::to_string(count) + " " + what + ", but the rest of the file has no room for them");
    }
    return static_cast<std::size_t>(count);
  }
  void Skip(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) Word();
  }

 private:
  std::string_view Word() {
    std::size_t begin = 0;
    for (; begin < text_.size() && (IsBlank(text_[begin]) || text_[begin] == '\n'); ++begin) {
      if (text_[begin] == '\n') ++line_;
    }
    std::size_t end = begin;
    while (end < text_.size() && !IsBlank(text_[end]) && text_[end] != '\n') ++end;
    if (begin == end) Fail("the file ends too early");
    const std::string_view word = text_.substr(begin, end - begin);
    text_.remove_prefix(end);
    return word;
  }

  std::string_view text_;
  std::string file_;
  std::size_t line_;
};

}  // namespace planegraph
