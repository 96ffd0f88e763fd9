#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace planegraph {

/// The content of a file in memory, read once and not copied. (A mapping would be as fast, but a
/// file that shrinks meanwhile would then kill the program.) Throws InputError.
class FileBytes {
 public:
  explicit FileBytes(const std::string& path);
  std::string_view view() const { return {data_.get(), size_}; }

 private:
  void Grow(const std::string& path);

  std::unique_ptr<char[]> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace planegraph
