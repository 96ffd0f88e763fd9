#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "planegraph/base/error.h"
#include "planegraph/io/tile_file.h"

namespace planegraph {

void CheckScratchRoom(const std::string& folder, std::uint64_t bytes) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error || space.available >= bytes) return;  // writing tells, where this does not
  throw InputError::InFile(
      folder, "has no room for the scratch file of a large drone map: " + std::to_string(bytes) +
                  " bytes are needed, " + std::to_string(space.available) + " are free");
}

ScratchFile::ScratchFile(const std::string& folder) : folder_(folder) {
  std::string name = folder + "/.planegraph_XXXXXX";
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) {
    throw InputError::InFile(
        folder, std::string("takes no scratch file of a large drone map: ") + std::strerror(errno));
  }
  ::unlink(name.c_str());
}

ScratchFile::~ScratchFile() { ::close(file_); }

void ScratchFile::WriteAt(std::uint64_t place, const void* data, std::size_t bytes) {
  const char* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const ::ssize_t done = ::pwrite(file_, from, bytes, static_cast<::off_t>(place));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) {
      throw InputError::InFile(folder_, std::string("has no room for the scratch file of a large "
                                                    "drone map: ") +
                                            std::strerror(done < 0 ? errno : ENOSPC));
    }
    from += done, place += static_cast<std::uint64_t>(done);
    bytes -= static_cast<std::size_t>(done);
  }
}

void ScratchFile::ReadAt(std::uint64_t place, void* data, std::size_t bytes) const {
  char* to = static_cast<char*>(data);
  while (bytes > 0) {
    const ::ssize_t done = ::pread(file_, to, bytes, static_cast<::off_t>(place));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) {
      throw InputError::InFile(
          folder_, std::string("gives the scratch file of a large drone map not back: ") +
                       (done < 0 ? std::strerror(errno) : "it is shorter than what was written"));
    }
    to += done, place += static_cast<std::uint64_t>(done);
    bytes -= static_cast<std::size_t>(done);
  }
}

}  // namespace planegraph
