#pragma once

#include <array>
#include <chrono>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sensor/ring/lost_ranges.hpp"
#include "sensor/ring/message.hpp"
#include "sensor/ring/segment_chain.hpp"

namespace divemesh::sensor {

// What the device has said and the server has not got yet, of this boot and of earlier ones: on
// disk, bounded, in segments that survive a power cut (SegmentChain). When there is no room the
// oldest are dropped and told as lost, as is what cannot be read any more. Where the disk cannot be
// written to it goes on in memory, with less room, and says so in trouble(). Any thread.
class MessageRing {
public:
    // Names a message; older ones first, whatever boot they are of.
    struct Key {
        int boot = 0;
        std::int64_t sequence = 0;
        auto operator<=>(const Key&) const = default;
    };
    enum class Pile { Texts, Previews };

    static constexpr std::int64_t kMinBytes = std::int64_t{2} << 20;
    static constexpr std::int64_t kMaxMemoryBytes = std::int64_t{4} << 20;

    // Throws Error{Conflict} when another process uses the folder, Error{InvalidArgument} for less
    // room than kMinBytes.
    MessageRing(const std::filesystem::path& folder, std::int64_t max_bytes, std::string boot_id);

    // Takes a message of this boot and gives it its sequence; its boot and sequence are not looked
    // at.
    std::int64_t append(Message message);
    // What was appended survives a power cut. To be called every second at the latest.
    void sync();

    const std::string& boot_id() const { return boot_id_; }
    std::string boot_id(Key key) const;
    // The newest of this boot.
    std::optional<Key> newest(MessageKind kind) const;
    // The oldest of a pile that is not among `taken`.
    std::optional<Key> oldest(Pile pile, const std::set<Key>& taken) const;
    bool is_of_this_boot(Key key) const { return key.boot == this_boot_; }
    // Nothing when it is gone or damaged, which is told as lost.
    std::optional<Message> read(Key key);

    // The server has them on its disk: they are forgotten.
    void committed(const std::string& boot_id, const SequenceRange& range);
    // The server will never take it.
    void refused(Key key);

    // The first boot of which something is lost that the server was not told, and what.
    struct Lost {
        std::string boot_id;
        std::vector<SequenceRange> ranges;  // kMaxLost of a report at most
    };
    std::optional<Lost> lost() const;
    std::vector<SequenceRange> lost_of(const std::string& boot_id) const;
    void reported_lost(const std::string& boot_id, const std::vector<SequenceRange>& ranges);

    std::size_t num_waiting() const;
    std::string trouble() const;  // "": the disk takes what is said

private:
    struct Entry {
        MessageKind kind = MessageKind::Status;
        SegmentChain::Place place;  // no segment: it is in memory
        std::string record;
    };
    using Entries = std::map<Key, Entry>;

    int boot_of(const std::string& boot_id);  // a new one when it is not known
    SegmentChain::Found loader();
    void lose_what_is_missing();
    Entries& entries_of(MessageKind kind) { return entries_.at(static_cast<std::size_t>(kind)); }
    void store(Key key, const Message& message);
    void keep_in_memory(Key key, MessageKind kind, std::string record);
    void make_room(std::size_t record_bytes);
    void drop_first_segment();
    void drop_from_memory();
    void forget(Entries::iterator entry, Entries& entries);
    void lose(Key key);
    void remove_finished_segments();
    void write_down_lost();
    void disk_failed(const std::exception& failure);
    bool disk_is_given_up() const;

    mutable std::mutex mutex_;
    std::string boot_id_;
    std::int64_t next_sequence_ = 0;
    std::vector<std::string> boots_;  // in the order in which they were
    int this_boot_ = 0;
    std::array<Entries, 4> entries_;  // of each kind
    std::map<const SegmentFile*, std::int64_t> num_waiting_in_;
    std::map<int, LostRanges> lost_;
    std::int64_t memory_bytes_ = 0;
    std::string trouble_;
    std::chrono::steady_clock::time_point try_disk_at_;
    bool is_damaged_ = false;
    std::map<int, LostRanges> accounted_;  // at the start: what became of a boot's messages
    SegmentChain chain_;                   // last: what it finds goes into the others
};

}  // namespace divemesh::sensor
