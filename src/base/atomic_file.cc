#include "planegraph/base/atomic_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "planegraph/base/error.h"

namespace planegraph {

AtomicFile::AtomicFile(const std::string& path)
    : path_(path), temporary_(path + ".part" + std::to_string(::getpid())) {
  stream_.open(temporary_, std::ios::binary | std::ios::trunc);
  if (!stream_) {
    throw InputError::InFile(path, std::string("cannot be written: ") + std::strerror(errno));
  }
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  stream_.close();
  std::remove(temporary_.c_str());
}

void AtomicFile::Write(const void* data, std::size_t bytes) {
  stream_.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
}

void AtomicFile::Commit() {
  stream_.close();
  if (!stream_) throw InputError::InFile(path_, "writing failed (is the disk full?)");
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    throw InputError::InFile(path_, std::string("cannot be written: ") + std::strerror(errno));
  }
  committed_ = true;
}

void WriteTextFile(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text.data(), text.size());
  file.Commit();
}

std::string ReadTextFile(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw InputError::InFile(path, "is a folder, not a file");
  }
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  if (!stream) {
    throw InputError::InFile(path, std::string("cannot be read: ") + std::strerror(errno));
  }
  std::string text(static_cast<std::size_t>(stream.tellg()), '\0');
  stream.seekg(0);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream) throw InputError::InFile(path, "reading failed");
  return text;
}

void CreateFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw InputError::InFile(path, "cannot be created: " + error.message());
}

}  // namespace planegraph
