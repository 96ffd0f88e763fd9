#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace planegraph {

/// A short mark of what a result was made from (FNV-1a, 64 bits): good against accidents, not
/// against malice.
class Fingerprint {
 public:
  /// Adds a text, told apart from its neighbours by its length.
  Fingerprint& Add(std::string_view text);
  Fingerprint& Add(double value);
  /// Adds a file by its name relative to `base`, its size and the time of its last change; of a
  /// folder all files in it, in name order.
  Fingerprint& AddFile(const std::string& path, const std::string& base);
  std::string Hex() const;

 private:
  void Bytes(std::string_view bytes);
  std::uint64_t hash_ = 14695981039346656037u;
};

/// The mark of everything that a site file names, and of the file itself. A site file that cannot
/// be read has one as well.
std::string SiteFingerprint(const std::string& site);

}  // namespace planegraph
