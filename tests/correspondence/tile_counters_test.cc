#include "correspondence/tile_counters.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace planegraph {
namespace {

TEST(TileCounters, CountsAsBitByBit) {
  std::mt19937_64 engine(1);
  for (int tiles = 0; tiles <= TileCounters::kMost; tiles += tiles < 20 ? 1 : 47) {
    std::vector<BitTile> columns(tiles + 1);
    // Many bits, so that the counts reach their highest bits.
    for (BitTile& column : columns) {
      for (auto& row : column) row = static_cast<std::uint16_t>(engine() | engine());
    }
    std::array<std::array<int, 16>, 16> expected{};
    TileCounters counters;
    for (int k = 0; k < tiles; ++k) {
      const int shift = static_cast<int>(engine() % 16);
      counters.Add(columns[k].data(), columns[k + 1].data(), shift);
      for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
          const std::uint16_t row = x + shift < 16 ? columns[k][y] : columns[k + 1][y];
          expected[y][x] += row >> (x + shift) % 16 & 1;
        }
      }
    }
    counters.Finish();
    for (int y = 0; y < 16; ++y) {
      std::array<std::uint8_t, 16> row;
      counters.Write(y, &row);
      for (int x = 0; x < 16; ++x) ASSERT_EQ(row[x], expected[y][x]) << tiles;
    }
  }
}

}  // namespace
}  // namespace planegraph
