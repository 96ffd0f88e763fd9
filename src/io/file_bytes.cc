#include "io/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

InputError ReadError(const std::string& path) {
  return InputError::InFile(path, std::string("cannot be read: ") + std::strerror(errno));
}

struct Descriptor {
  explicit Descriptor(const std::string& path) : value(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (value < 0) throw ReadError(path);
  }
  ~Descriptor() { ::close(value); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int value;
};

// Pipes have no size: they start small and grow. A regular file needs one byte more to meet its
// end.
std::size_t FirstCapacity(const Descriptor& file, const std::string& path) {
  struct stat status {};
  if (::fstat(file.value, &status) != 0) throw ReadError(path);
  if (S_ISDIR(status.st_mode)) throw InputError::InFile(path, "is a folder, not a file");
  return std::max<std::size_t>(4096, static_cast<std::size_t>(status.st_size) + 1);
}

}  // namespace

FileBytes::FileBytes(const std::string& path) {
  const Descriptor file(path);
  capacity_ = FirstCapacity(file, path) / 2 + 1;
  Grow(path);
  while (true) {
    const ::ssize_t got = ::read(file.value, data_.get() + size_, capacity_ - size_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw ReadError(path);
    if (got == 0) return;
    size_ += static_cast<std::size_t>(got);
    if (size_ == capacity_) Grow(path);
  }
}

void FileBytes::Grow(const std::string& path) {
  capacity_ *= 2;
  std::unique_ptr<char[]> larger(new (std::nothrow) char[capacity_]);
  if (!larger) throw InputError::InFile(path, "does not fit in memory");
  if (size_ > 0) std::memcpy(larger.get(), data_.get(), size_);
  data_ = std::move(larger);
}

}  // namespace planegraph
