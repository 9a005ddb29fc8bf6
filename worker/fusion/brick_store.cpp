#include "worker/fusion/brick_store.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>
#include <utility>

#include "worker/base/lanes.hpp"

namespace divemesh::fusion {
namespace {

// Leaves per slot: more would waste memory where bricks have few leaves, fewer would cost more
// handles.
constexpr int kLeavesPerSlot = 2;
constexpr std::size_t kMaxLeafSlots = kBlockSamples / kLeavesPerSlot;
// Layout of a record, in words of 32 bits: owner; number of leaves and of slots; the slots'
// handles; the places of the leaves, two per word.
constexpr std::size_t kHeaderWords = 2;
constexpr std::size_t kWordsPerSlot = 1 + kLeavesPerSlot / 2;
constexpr std::uint32_t kPageWords = 1U << 10;
constexpr std::size_t kSlackWords = 4;  // that find_place() may read past the end of a page

constexpr std::uint32_t words_of(std::size_t num_slots) {
    return static_cast<std::uint32_t>(kHeaderWords + kWordsPerSlot * num_slots);
}
constexpr std::uint32_t records_per_page(std::size_t num_slots) {
    return kPageWords / words_of(num_slots);
}

// Returns the index of a place among the first `num`, or -1. Compares eight at a time, some of them
// past the end.
int find_place(const std::uint16_t* places, int num, int place) {
    const base::Shorts wanted = base::Shorts{} + static_cast<std::uint16_t>(place);
    for (int i = 0; i < num; i += base::kLanes) {
        const auto equal = base::load_lanes<base::Shorts>(places + i) == wanted;
        std::array<std::uint64_t, 2> halves;  // an equal lane has all 16 bits set
        std::memcpy(halves.data(), &equal, sizeof halves);
        if ((halves[0] | halves[1]) == 0) continue;
        const int lane = halves[0] != 0 ? std::countr_zero(halves[0]) / 16
                                        : 4 + std::countr_zero(halves[1]) / 16;
        return i + lane < num ? i + lane : -1;
    }
    return -1;
}

}  // namespace

template <typename Word>
struct BrickStore::Record {
    using Place = std::conditional_t<std::is_const_v<Word>, const std::uint16_t, std::uint16_t>;

    Word* words;

    std::uint32_t owner() const { return words[0]; }
    int num_leaves() const { return static_cast<int>(words[1] & 0xffff); }
    std::size_t num_slots() const { return words[1] >> 16; }
    Word* slots() const { return words + kHeaderWords; }
    Place* places() const { return reinterpret_cast<Place*>(slots() + num_slots()); }
};

BrickStore::BrickStore(SpillSettings spill, Moved moved)
    : leaves_(std::move(spill)), moved_(std::move(moved)), sizes_(kMaxLeafSlots + 1) {}

std::int64_t BrickStore::index_bytes() const {
    return static_cast<std::int64_t>(pages_.size() * (kPageWords + kSlackWords) *
                                     sizeof(std::uint32_t));
}

BrickStore::Record<std::uint32_t> BrickStore::record(Handle brick) {
    return {pages_[brick / kPageWords].get() + brick % kPageWords};
}
BrickStore::Record<const std::uint32_t> BrickStore::record(Handle brick) const {
    return {pages_[brick / kPageWords].get() + brick % kPageWords};
}

BrickStore::Handle BrickStore::make(std::uint32_t owner) {
    const Handle brick = take_record(1);
    std::uint32_t* words = record(brick).words;
    words[0] = owner;
    words[1] = 1U << 16;
    words[kHeaderWords] = leaves_.allocate(kLeavesPerSlot * sizeof(PointLeaf));
    return brick;
}

PointLeaf& BrickStore::leaf(Handle brick, int place) {
    auto found = record(brick);
    int i = find_place(found.places(), found.num_leaves(), place);
    if (i < 0) {
        i = found.num_leaves();
        if (i == kLeavesPerSlot * static_cast<int>(found.num_slots()))
            found = record(add_slot(brick));
        found.places()[i] = static_cast<std::uint16_t>(place);
        ++found.words[1];
        ++num_leaves_;
    }
    return reinterpret_cast<PointLeaf*>(
        leaves_.write(found.slots()[i / kLeavesPerSlot]))[i % kLeavesPerSlot];
}

const PointLeaf* BrickStore::find(Handle brick, int place) const {
    const auto found = record(brick);
    const int i = find_place(found.places(), found.num_leaves(), place);
    if (i < 0) return nullptr;
    return reinterpret_cast<const PointLeaf*>(leaves_.read(found.slots()[i / kLeavesPerSlot])) +
           i % kLeavesPerSlot;
}

void BrickStore::for_each(Handle brick,
                          const std::function<void(int place, const PointLeaf&)>& visit) const {
    const auto found = record(brick);
    std::array<std::uint16_t, kBlockSamples> index{};  // of the leaf at each occupied place
    std::array<std::uint64_t, kBlockSamples / 64> there{};
    for (int i = 0; i < found.num_leaves(); ++i) {
        const int place = found.places()[i];
        index[place] = static_cast<std::uint16_t>(i);
        there[place / 64] |= std::uint64_t{1} << (place % 64);
    }
    std::array<const PointLeaf*, kMaxLeafSlots> slots{};
    for (std::size_t i = 0; i < found.num_slots(); ++i)
        slots[i] = reinterpret_cast<const PointLeaf*>(leaves_.read(found.slots()[i]));
    for (std::size_t word = 0; word < there.size(); ++word)
        for (std::uint64_t left = there[word]; left != 0; left &= left - 1) {
            const int place = static_cast<int>(word) * 64 + std::countr_zero(left);
            visit(place, slots[index[place] / kLeavesPerSlot][index[place] % kLeavesPerSlot]);
        }
}

BrickStore::Handle BrickStore::record_at(std::size_t num_slots, std::uint32_t i) const {
    const std::uint32_t per_page = records_per_page(num_slots);
    return sizes_[num_slots].pages[i / per_page] * kPageWords + i % per_page * words_of(num_slots);
}

BrickStore::Handle BrickStore::take_record(std::size_t num_slots) {
    auto& [pages, num_records] = sizes_[num_slots];
    if (num_records == pages.size() * records_per_page(num_slots)) {
        if (free_pages_.empty()) {
            free_pages_.push_back(static_cast<std::uint32_t>(pages_.size()));
            pages_.push_back(std::make_unique<std::uint32_t[]>(kPageWords + kSlackWords));
        }
        pages.push_back(free_pages_.back());
        free_pages_.pop_back();
    }
    return record_at(num_slots, num_records++);
}

// Frees a record: the last record of this size moves into it.
void BrickStore::give_back(Handle brick, std::size_t num_slots) {
    auto& [pages, num_records] = sizes_[num_slots];
    const Handle last = record_at(num_slots, --num_records);
    if (last != brick) {
        std::memcpy(
            record(brick).words, record(last).words, words_of(num_slots) * sizeof(std::uint32_t));
        moved_(record(brick).owner(), brick);
    }
    if (num_records % records_per_page(num_slots) == 0) {
        free_pages_.push_back(pages.back());
        pages.pop_back();
    }
}

BrickStore::Handle BrickStore::add_slot(Handle brick) {
    const std::size_t num_slots = record(brick).num_slots();
    const Handle larger = take_record(num_slots + 1);
    const auto from = record(brick);
    const auto to = record(larger);
    to.words[0] = from.words[0];
    to.words[1] = from.words[1] + (1U << 16);
    std::copy_n(from.slots(), num_slots, to.slots());
    to.slots()[num_slots] = leaves_.allocate(kLeavesPerSlot * sizeof(PointLeaf));
    std::copy_n(from.places(), from.num_leaves(), to.places());
    moved_(to.owner(), larger);
    give_back(brick, num_slots);
    return larger;
}

}  // namespace divemesh::fusion
