#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <string>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"

namespace planegraph {

/// A test with a folder of its own, which goes away with it.
class TestFolder : public testing::Test {
 protected:
  TestFolder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("planegraph_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" +
               std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~TestFolder() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    WriteTextFile(Path(name), content);
    return Path(name);
  }

 private:
  std::filesystem::path folder_;
};

/// The bytes of a value, for binary files built by hand.
template <typename T>
std::string Bytes(T value, bool big_endian = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

template <typename T>
std::string Triple(T x, T y, T z, bool big_endian = false) {
  return Bytes(x, big_endian) + Bytes(y, big_endian) + Bytes(z, big_endian);
}

/// What is wrong with the input, in the words of the error.
template <typename Read>
std::string ErrorOf(const Read& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "(no error)";
}

}  // namespace planegraph
