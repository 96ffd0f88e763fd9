#pragma once

#include <fstream>
#include <string>

namespace planegraph {

/// An output file that appears whole or not at all: written beside its place under a temporary name
/// and renamed by Commit(). Without Commit() nothing is left behind. Throws InputError.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream() { return stream_; }
  void Write(const void* data, std::size_t bytes);
  void Commit();

 private:
  std::string path_, temporary_;
  std::ofstream stream_;
  bool committed_ = false;
};

/// Writes `text` to `path` atomically.
void WriteTextFile(const std::string& path, const std::string& text);

/// The whole content of a file. Throws InputError where it cannot be read.
std::string ReadTextFile(const std::string& path);

/// Creates the folder and its parents. Throws InputError where that fails.
void CreateFolder(const std::string& path);

}  // namespace planegraph
