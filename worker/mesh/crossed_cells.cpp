#include "worker/mesh/crossed_cells.hpp"

#include <bit>
#include <cmath>

namespace divemesh::mesh {
namespace {

constexpr int kEdge = BlockNeighbourhood::kEdge;

// The nine samples along x, one bit each.
struct RowBits {
    unsigned behind = 0;
    unsigned unknown = 0;
};

RowBits bits_of(const float* distances_m) {
    RowBits row;
    for (int x = 0; x < kEdge; ++x) {
        row.behind |= (distances_m[x] < 0.0F ? 1U : 0U) << x;
        row.unknown |= (std::isnan(distances_m[x]) ? 1U : 0U) << x;
    }
    return row;
}

// Returns a bit for each of the eight cells between four rows: known and not all of one sign.
unsigned crossed(const std::array<RowBits, 4>& rows) {
    unsigned some = 0, all = ~0U, unknown = 0;
    for (const RowBits& row : rows) {
        some |= row.behind;
        all &= row.behind;
        unknown |= row.unknown;
    }
    return (some | (some >> 1)) & ~(all & (all >> 1)) & ~(unknown | (unknown >> 1)) &
           ((1U << fusion::kBlockEdge) - 1);
}

}  // namespace

std::vector<CrossedCell> find_crossed_cells(const BlockNeighbourhood& samples) {
    std::array<RowBits, std::size_t{kEdge} * kEdge> rows;
    for (int row = 0; row < kEdge * kEdge; ++row)
        rows[row] = bits_of(samples.distances_m.data() + std::ptrdiff_t{row} * kEdge);
    std::vector<CrossedCell> cells;
    for (int z = 0; z < fusion::kBlockEdge; ++z)
        for (int y = 0; y < fusion::kBlockEdge; ++y) {
            const int row = z * kEdge + y;
            unsigned here =
                crossed({rows[row], rows[row + 1], rows[row + kEdge], rows[row + kEdge + 1]});
            for (; here != 0; here &= here - 1) {
                CrossedCell& cell = cells.emplace_back();
                cell.place = {std::countr_zero(here), y, z};
                for (int c = 0; c < 8; ++c)
                    cell.corners_m[c] = samples.distances_m[BlockNeighbourhood::index(
                        cell.place.x() + (c & 1), y + ((c >> 1) & 1), z + (c >> 2))];
            }
        }
    return cells;
}

}  // namespace divemesh::mesh
