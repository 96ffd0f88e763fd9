// A file in parts against the same as a whole, and by way of tiles on disk.
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <optional>

#include "fuzz/fuzz_reader.h"
#include "io/cloud_formats.h"
#include "planegraph/io/cloud_parts.h"
#include "planegraph/io/tile_file.h"

namespace planegraph {
namespace {

// The bytes as a file in memory alone.
class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size) : file_(::memfd_create("fuzz", 0)) {
    if (::write(file_, data, size) != static_cast<::ssize_t>(size)) __builtin_trap();
  }
  ~MemoryFile() { ::close(file_); }
  std::string Path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

std::optional<Cloud> AsAWhole(std::string_view bytes) {
  try {
    return bytes.starts_with("ply") ? ParsePly(bytes, "fuzz") : ParsePcd(bytes, "fuzz");
  } catch (const InputError&) {
    return {};
  }
}

bool SameBytes(const void* a, const void* b, std::size_t bytes) {
  return bytes == 0 || std::memcmp(a, b, bytes) == 0;
}

template <typename T>
bool Same(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && SameBytes(a.data(), b.data(), a.size() * sizeof(T));
}

template <typename T>
void Append(const std::vector<T>& from, std::vector<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

Cloud InParts(const std::string& path, std::size_t most) {
  CloudParts parts(path, most);
  TileFile tiles("/dev/shm", 10.0, 64);
  Cloud all, part;
  while (parts.Next(&part)) {
    CheckCloud(part);
    if (part.size() > most) __builtin_trap();
    if (part.size() > 0) all.offset = part.offset, all.viewpoint = part.viewpoint;
    Append(part.points, &all.points);
    Append(part.normals, &all.normals);
    Append(part.colors, &all.colors);
    Append(part.intensities, &all.intensities);
    tiles.Add(part);
  }
  tiles.Finish();
  std::size_t points = 0;
  for (std::size_t t = 0; t < tiles.count(); ++t) {
    const Cloud tile = tiles.Load(t);
    CheckCloud(tile);
    points += tile.size();
    if (tile.size() != tiles.PointsOf(t)) __builtin_trap();
  }
  if (points != all.size()) __builtin_trap();
  return all;
}

void CheckSame(const Cloud& whole, const Cloud& parts) {
  const bool same = Same(whole.points, parts.points) && Same(whole.normals, parts.normals) &&
                    Same(whole.colors, parts.colors) && Same(whole.intensities, parts.intensities);
  const bool placed =
      whole.size() == 0 || (whole.offset == parts.offset && whole.viewpoint == parts.viewpoint);
  if (!same || !placed) __builtin_trap();
}

}  // namespace
}  // namespace planegraph

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planegraph;
  const MemoryFile file(data, size);
  return FuzzReader(data, size, [&](std::string_view bytes) {
    if (!CloudParts::CanRead(file.Path())) return;
    const std::optional<Cloud> whole = AsAWhole(bytes);
    const Cloud parts = InParts(file.Path(), 1 + size % 5);
    if (!whole) __builtin_trap();
    CheckSame(*whole, parts);
  });
}
