// COLMAP's binary model (cameras.bin, images.bin, points3D.bin): little endian, unpadded.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "io/camera_formats.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

// Takes values from the bytes of a file; every step is checked against what is left.
class ByteStream {
 public:
  ByteStream(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError::AtByte(file_, position_, reason);
  }
  std::size_t left() const { return bytes_.size() - position_; }
  void Need(std::size_t count) const {
    if (count > left()) {
      Fail("the file ends " + std::to_string(count - left()) + " bytes before its data do");
    }
  }
  template <typename T>
  T Take() {
    Need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }
  double Finite() {
    const auto value = Take<double>();
    if (!std::isfinite(value)) Fail("holds what is no finite number");
    return value;
  }
  /// A count of records of at least `record_bytes` each.
  std::size_t Count(std::size_t record_bytes, const std::string& what) {
    const auto count = Take<std::uint64_t>();
    if (count > left() / record_bytes) {
      Fail(std::to_string(count) + " " + what + ", but only " + std::to_string(left()) +
           " bytes are left");
    }
    return static_cast<std::size_t>(count);
  }
  void Skip(std::size_t count) {
    Need(count);
    position_ += count;
  }
  std::string ZeroTerminated() {
    const std::size_t end = bytes_.find('\0', position_);
    if (end == bytes_.npos) Fail("a name has no end");
    const std::string_view text = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    return std::string(text);
  }

 private:
  std::string_view bytes_;
  const std::string& file_;
  std::size_t position_ = 0;
};

// Number of parameters of COLMAP's camera models, by their ids; the first is a focal length in all.
constexpr std::array<std::size_t, 12> kParameterCounts = {3, 4, 4, 5, 8, 8, 12, 5, 4, 5, 12, 16};
constexpr std::size_t kLeastCameraBytes = 24 + 3 * 8, kLeastImageBytes = 64 + 1 + 8,
                      kKeyPointBytes = 24, kLeastPointBytes = 43 + 8, kTrackBytes = 8;

Camera TakeImage(ByteStream* stream, const FocalLengths& focal_lengths) {
  Camera camera;
  stream->Take<std::uint32_t>();
  Eigen::Quaterniond& rotation = camera.camera_from_model.rotation;
  for (double* part : {&rotation.w(), &rotation.x(), &rotation.y(), &rotation.z()}) {
    *part = stream->Finite();
  }
  if (!(std::abs(rotation.norm() - 1.0) <= 1e-2)) stream->Fail("the quaternion's norm is not 1");
  rotation.normalize();
  for (double& part : camera.camera_from_model.translation) part = stream->Finite();
  const auto focal = focal_lengths.find(stream->Take<std::uint32_t>());
  camera.focal = focal == focal_lengths.end() ? 0.0 : focal->second;
  camera.image = stream->ZeroTerminated();
  if (camera.image.empty()) stream->Fail("the image has no name");
  stream->Skip(kKeyPointBytes * stream->Count(kKeyPointBytes, "key points"));
  camera.valid = true;
  return camera;
}

}  // namespace

FocalLengths ParseColmapCamerasBinary(std::string_view bytes, const std::string& file) {
  ByteStream stream(bytes, file);
  FocalLengths focal_lengths;
  const std::size_t count = stream.Count(kLeastCameraBytes, "cameras");
  for (std::size_t i = 0; i < count; ++i) {
    const auto id = stream.Take<std::uint32_t>();
    const auto model = stream.Take<std::int32_t>();
    if (model < 0 || static_cast<std::size_t>(model) >= kParameterCounts.size()) {
      stream.Fail("unknown camera model " + std::to_string(model));
    }
    stream.Skip(16);
    const double focal = stream.Finite();
    if (!(focal > 0.0)) stream.Fail("the focal length is not positive");
    stream.Skip(8 * (kParameterCounts[static_cast<std::size_t>(model)] - 1));
    focal_lengths[id] = focal;
  }
  return focal_lengths;
}

std::vector<Camera> ParseColmapImagesBinary(std::string_view bytes,
                                            const FocalLengths& focal_lengths,
                                            const std::string& file) {
  ByteStream stream(bytes, file);
  std::vector<Camera> cameras;
  const std::size_t count = stream.Count(kLeastImageBytes, "images");
  cameras.reserve(count);
  for (std::size_t i = 0; i < count; ++i) cameras.push_back(TakeImage(&stream, focal_lengths));
  return cameras;
}

std::vector<Eigen::Vector3d> ParseColmapPointsBinary(std::string_view bytes,
                                                     const std::string& file) {
  ByteStream stream(bytes, file);
  std::vector<Eigen::Vector3d> points;
  const std::size_t count = stream.Count(kLeastPointBytes, "points");
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    stream.Take<std::uint64_t>();
    Eigen::Vector3d point;
    for (double& part : point) part = stream.Finite();
    stream.Skip(3 + 8);
    stream.Skip(kTrackBytes * stream.Count(kTrackBytes, "views"));
    points.push_back(point);
  }
  return points;
}

}  // namespace planegraph
