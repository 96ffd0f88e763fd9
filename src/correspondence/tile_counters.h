#pragma once

#include <array>
#include <cstdint>
#include <cstring>

namespace planegraph {

/// A square of 16 x 16 bits: row y in the y-th number, column x in its bit of the value 2^x.
using BitTile = std::array<std::uint16_t, 16>;

/// Counts how many of some tiles have each bit set, 64 bits at once: each bit of the counts is in a
/// tile of its own, and tiles are added by logic, eight at a time.
class TileCounters {
 public:
  static constexpr int kMost = 255;  ///< tiles that can be counted

  /// Adds the tile that begins at column `shift` (0 to 15) of `left`, sixteen rows in turn, and
  /// ends in `right`, its neighbour. Both are read later: they stay until `Write`.
  void Add(const std::uint16_t* left, const std::uint16_t* right, int shift) {
    waiting_[count_] = {left, right, shift};
    if (++count_ == kAtOnce) AddWaiting();
  }

  /// Ends the adding, before the first `Write`.
  void Finish() {
    static constexpr BitTile kEmpty{};
    while (count_ > 0) Add(kEmpty.data(), kEmpty.data(), 0);
  }
  /// The counts of row y.
  void Write(int y, std::array<std::uint8_t, 16>* counts) const {
    for (int first = 0; first < 16; first += 8) {
      std::uint64_t eight = 0;
      for (int k = 0; k < 8; ++k) {
        eight |= Spread(bits_[k][y / 4] >> (16 * (y % 4) + first) & 255) << k;
      }
      for (int k = 0; k < 8; ++k) (*counts)[first + k] = static_cast<std::uint8_t>(eight >> 8 * k);
    }
  }

 private:
  static constexpr int kAtOnce = 8, kWords = 4;
  using Words = std::array<std::uint64_t, kWords>;
  struct Shifted {
    const std::uint16_t *left, *right;
    int shift;
  };

  static Words Read(const Shifted& tile) {
    Words left, right;
    std::memcpy(left.data(), tile.left, sizeof(left));
    std::memcpy(right.data(), tile.right, sizeof(right));
    // The columns that `left` has, in each row.
    const std::uint64_t in_left = (0xffffu >> tile.shift) * 0x0001000100010001u;
    for (int w = 0; w < kWords; ++w) {
      left[w] = (left[w] >> tile.shift & in_left) | (right[w] << 1 << (15 - tile.shift) & ~in_left);
    }
    return left;
  }

  // Adds two bits to the sum's and returns the carry, everywhere.
  static Words AddTwo(const Words& a, const Words& b, Words* sum) {
    Words carry;
    for (int w = 0; w < kWords; ++w) {
      const std::uint64_t half = a[w] ^ b[w];
      carry[w] = (a[w] & b[w]) | (half & (*sum)[w]);
      (*sum)[w] ^= half;
    }
    return carry;
  }

  // Full adders, as a tree that leaves one carry of eight.
  void AddWaiting() {
    count_ = 0;
    const Words a = AddTwo(Read(waiting_[0]), Read(waiting_[1]), &bits_[0]);
    const Words b = AddTwo(Read(waiting_[2]), Read(waiting_[3]), &bits_[0]);
    const Words c = AddTwo(Read(waiting_[4]), Read(waiting_[5]), &bits_[0]);
    const Words d = AddTwo(Read(waiting_[6]), Read(waiting_[7]), &bits_[0]);
    const Words e = AddTwo(a, b, &bits_[1]), f = AddTwo(c, d, &bits_[1]);
    Words carry = AddTwo(e, f, &bits_[2]);
    for (int k = 3; k < 8; ++k) {
      for (int w = 0; w < kWords; ++w) {
        const std::uint64_t next = bits_[k][w] & carry[w];
        bits_[k][w] ^= carry[w];
        carry[w] = next;
      }
    }
  }

  // Bit k as the lowest one of byte k.
  static std::uint64_t Spread(std::uint64_t bits) {
    return ((bits & 127) * 0x0002040810204081u & 0x0001010101010101u) | bits >> 7 << 56;
  }

  std::array<Words, 8> bits_{};  // of the counts, lowest first
  std::array<Shifted, kAtOnce> waiting_;
  int count_ = 0;
};

}  // namespace planegraph
