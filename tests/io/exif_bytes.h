#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "io/test_files.h"

namespace planegraph {

/// A JPEG of nothing but its EXIF: TIFF, little endian, with a GPS directory.
class ExifBytes {
 public:
  ExifBytes& Letter(std::uint16_t tag, char letter) {
    return Entry(tag, 2, 2, Bytes(std::uint32_t(static_cast<unsigned char>(letter))));
  }
  ExifBytes& Byte(std::uint16_t tag, std::uint8_t value) {
    return Entry(tag, 1, 1, Bytes(std::uint32_t(value)));
  }
  /// Numerators over one denominator.
  ExifBytes& Rationals(std::uint16_t tag, const std::vector<std::uint32_t>& numerators,
                       std::uint32_t denominator) {
    const auto place = static_cast<std::uint32_t>(kValues + values_.size());
    for (const std::uint32_t n : numerators) values_ += Bytes(n) + Bytes(denominator);
    return Entry(tag, 5, static_cast<std::uint32_t>(numerators.size()), Bytes(place));
  }
  std::string Jpeg() const {
    const std::uint32_t gps = 8 + 2 + 12 + 4;
    std::string tiff = "II" + Bytes(std::uint16_t(42)) + Bytes(std::uint32_t(8));
    tiff += Bytes(std::uint16_t(1)) + Bytes(std::uint16_t(0x8825)) + Bytes(std::uint16_t(4)) +
            Bytes(std::uint32_t(1)) + Bytes(gps) + Bytes(std::uint32_t(0));
    tiff += Bytes(count_) + entries_ + Bytes(std::uint32_t(0));
    tiff.resize(kValues, '\0');
    tiff += values_;
    const auto length = static_cast<std::uint16_t>(tiff.size() + 8);
    return "\xFF\xD8\xFF\xE1" + Bytes(length, true) + std::string("Exif\0\0", 6) + tiff +
           "\xFF\xD9";
  }

 private:
  static constexpr std::size_t kValues = 200;  // place of the rationals in the TIFF part

  ExifBytes& Entry(std::uint16_t tag, std::uint16_t format, std::uint32_t count,
                   const std::string& value) {
    entries_ += Bytes(tag) + Bytes(format) + Bytes(count) + value;
    ++count_;
    return *this;
  }

  std::string entries_, values_;
  std::uint16_t count_ = 0;
};

}  // namespace planegraph
