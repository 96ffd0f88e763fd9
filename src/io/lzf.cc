#include "io/lzf.h"

#include <cstring>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

class LzfReader {
 public:
  LzfReader(std::string_view packed, std::size_t unpacked_size, const std::string& file,
            std::size_t position)
      : packed_(packed), file_(file), position_(position), out_(unpacked_size) {}

  std::vector<char> Unpack() {
    while (at_ < packed_.size()) {
      const unsigned control = NextByte();
      if (control < 32) {
        CopyLiteral(control + 1);
      } else {
        CopyBack(control);
      }
    }
    if (filled_ != out_.size()) Fail("the compressed data end too early");
    return std::move(out_);
  }

 private:
  [[noreturn]] void Fail(const char* reason) {
    throw InputError::AtByte(file_, position_ + at_, reason);
  }
  unsigned NextByte() {
    if (at_ == packed_.size()) Fail("the compressed data are cut off");
    return static_cast<unsigned char>(packed_[at_++]);
  }
  void CheckRoom(std::size_t length) {
    if (length > out_.size() - filled_) Fail("the compressed data are longer than the header says");
  }
  void CopyLiteral(std::size_t length) {
    if (length > packed_.size() - at_) Fail("the compressed data are cut off");
    CheckRoom(length);
    std::memcpy(out_.data() + filled_, packed_.data() + at_, length);
    at_ += length;
    filled_ += length;
  }
  // Source and target may overlap: byte by byte, a short distance repeats its bytes.
  void CopyBack(unsigned control) {
    std::size_t length = control >> 5;
    if (length == 7) length += NextByte();
    length += 2;
    const std::size_t distance = ((control & 31u) << 8 | NextByte()) + 1;
    if (distance > filled_) Fail("the compressed data refer to before their start");
    CheckRoom(length);
    const char* from = out_.data() + filled_ - distance;
    for (std::size_t i = 0; i < length; ++i) out_[filled_ + i] = from[i];
    filled_ += length;
  }

  std::string_view packed_;
  const std::string& file_;
  std::size_t position_, at_ = 0, filled_ = 0;
  std::vector<char> out_;
};

}  // namespace

std::vector<char> UnpackLzf(std::string_view packed, std::size_t unpacked_size,
                            const std::string& file, std::size_t position) {
  return LzfReader(packed, unpacked_size, file, position).Unpack();
}

}  // namespace planegraph
