#include "report/png.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "report/png_reader.h"

namespace planegraph {
namespace {

// RFC 4648, section 10.
TEST(Base64, TestVectors) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foob"), "Zm9vYg==");
  EXPECT_EQ(Base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64("\xff\xff\xfe"), "///+");
}

TEST(Png, ReadsBack) {
  IndexedImage image{37, 23, {}};
  for (std::size_t i = 0; i < 37 * 23; ++i) {
    image.pixels.push_back(static_cast<std::uint8_t>(i * i % 3));
  }
  DecodedPng png;
  DecodePng(EncodePng(image, {{1, 2, 3, 4}, {5, 6, 7, 8}, {255, 254, 253, 252}}), &png);
  EXPECT_EQ(png.width, 37u);
  EXPECT_EQ(png.height, 23u);
  EXPECT_EQ(png.pixels, image.pixels);
  EXPECT_EQ(png.palette, "\x01\x02\x03\x05\x06\x07\xff\xfe\xfd");
  EXPECT_EQ(png.opacities, "\x04\x08\xfc");
}

TEST(Png, RefusesSizesThatDoNotFit) {
  EXPECT_THROW(EncodePng({2, 2, {0, 0, 0}}, {{0, 0, 0, 0}}), std::invalid_argument);
  EXPECT_THROW(EncodePng({1, 1, {0}}, {}), std::invalid_argument);
  EXPECT_THROW(EncodePng({0, 0, {}}, {{0, 0, 0, 0}}), std::invalid_argument);
}

}  // namespace
}  // namespace planegraph
