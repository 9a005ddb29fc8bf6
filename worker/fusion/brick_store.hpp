#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "worker/fusion/block_coordinate.hpp"
#include "worker/fusion/spill_store.hpp"

namespace divemesh::fusion {

// All that was seen in one leaf, in 16 bytes: weighted means, not the observations; packed as
// worker/fusion/packed_values.hpp says.
struct PointLeaf {
    std::uint16_t weight = 0;    // sum
    std::uint8_t num_views = 0;  // up to 255
    std::uint8_t last_view = 0;
    std::uint32_t place = 0;   // in the leaf, shares of its edge
    std::uint32_t normal = 0;  // mean; from -1 to 1
    std::uint32_t color = 0;   // red, green, blue
};
static_assert(sizeof(PointLeaf) == 16);

// Bricks of leaves: those that exist of 8 x 8 x 8. Leaves are in rooms of two, in the order in
// which they were made; they stay where they are, beside what was seen at the same time, so that
// those not in use of late can go to disk when there are many. What leads to them is in memory, in
// a record just large enough. Records of one size lie one after the other in pages. A brick that
// has outgrown its record moves to one of the next size, and the last of its old size takes its
// place: whatever the order in which bricks grow, nothing lies idle but the end of each size's last
// page. One thread at a time; reading, any number.
class BrickStore {
public:
    using Handle = std::uint32_t;
    // Told where the brick of this owner is from now on.
    using Moved = std::function<void(std::uint32_t owner, Handle brick)>;

    BrickStore(SpillSettings spill, Moved moved);

    Handle make(std::uint32_t owner);  // without leaves
    // The leaf at index_in_block() `place`, made when there is none: then this brick and another
    // one may move.
    PointLeaf& leaf(Handle brick, int place);
    const PointLeaf* find(Handle brick, int place) const;  // null: none
    // All leaves by place.
    void for_each(Handle brick,
                  const std::function<void(int place, const PointLeaf&)>& visit) const;
    // Leaves beyond what may be in memory go; no pointer to a leaf outlives it.
    void trim() const { leaves_.trim(); }

    std::int64_t num_leaves() const { return num_leaves_; }
    std::int64_t size_bytes() const { return index_bytes() + leaves_.size_bytes(); }
    std::int64_t memory_bytes() const { return index_bytes() + leaves_.memory_bytes(); }

private:
    // What leads to the leaves of a brick: a view of a record.
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
    std::vector<Size> sizes_;  // of records, by their number of rooms
    std::int64_t num_leaves_ = 0;
};

}  // namespace divemesh::fusion
