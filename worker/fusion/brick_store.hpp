#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "worker/fusion/block_coordinate.hpp"
#include "worker/fusion/spill_store.hpp"

namespace divemesh::fusion {

// One octree leaf in 16 bytes: weighted means of the observations, not the observations themselves.
// Packed as described in worker/fusion/packed_values.hpp.
struct PointLeaf {
    std::uint16_t weight = 0;    // sum of the observations' weights
    std::uint8_t num_views = 0;  // up to 255
    std::uint8_t last_view = 0;
    std::uint32_t place = 0;   // mean position in the leaf, as shares of its edge
    std::uint32_t normal = 0;  // mean normal; components from -1 to 1
    std::uint32_t color = 0;   // mean red, green, blue
};
static_assert(sizeof(PointLeaf) == 16);

// Stores bricks of 8 x 8 x 8 leaves, of which only the occupied ones exist. Leaves are allocated in
// slots of two, in the order in which they are made, and never move: leaves that were seen together
// stay together, so that those not used lately can be spilled to disk. The index of a brick is in
// memory, in a record just large enough. Records of one size are contiguous in pages. A brick that
// outgrows its record moves to one of the next size, and the last record of the old size fills the
// gap: however bricks grow, only the end of each size's last page is unused. Writing is for one
// thread at a time, reading for any number.
class BrickStore {
public:
    using Handle = std::uint32_t;
    // Called with the new handle of a brick that moved.
    using Moved = std::function<void(std::uint32_t owner, Handle brick)>;

    BrickStore(SpillSettings spill, Moved moved);

    Handle make(std::uint32_t owner);  // Makes a brick without leaves.
    // Returns the leaf at index_in_block() `place`; creates it if it does not exist, in which case
    // this brick and one other may move.
    PointLeaf& leaf(Handle brick, int place);
    // Returns null if the leaf does not exist.
    const PointLeaf* find(Handle brick, int place) const;
    // Visits all leaves in order of their place.
    void for_each(Handle brick,
                  const std::function<void(int place, const PointLeaf&)>& visit) const;
    // Spills leaves beyond the memory limit. Invalidates all pointers to leaves.
    void trim() const { leaves_.trim(); }

    std::int64_t num_leaves() const { return num_leaves_; }
    std::int64_t size_bytes() const { return index_bytes() + leaves_.size_bytes(); }
    std::int64_t memory_bytes() const { return index_bytes() + leaves_.memory_bytes(); }

private:
    // The index entries of a brick's leaves: a view of a record.
    template <typename Word>
    struct Record;
    struct Size {
        std::vector<std::uint32_t> pages;
        std::uint32_t num_records = 0;
    };

    std::int64_t index_bytes() const;
    Record<std::uint32_t> record(Handle brick);
    Record<const std::uint32_t> record(Handle brick) const;
    Handle record_at(std::size_t num_slots, std::uint32_t i) const;
    Handle take_record(std::size_t num_slots);
    void give_back(Handle brick, std::size_t num_slots);
    Handle add_slot(Handle brick);

    SpillStore leaves_;
    Moved moved_;
    std::vector<std::unique_ptr<std::uint32_t[]>> pages_;
    std::vector<std::uint32_t> free_pages_;
    std::vector<Size> sizes_;  // records, by their number of slots
    std::int64_t num_leaves_ = 0;
};

}  // namespace divemesh::fusion
