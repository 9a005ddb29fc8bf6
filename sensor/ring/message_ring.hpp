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

// The messages that the server does not have yet, of this boot and earlier ones: on disk, bounded,
// in segments that survive a power cut (SegmentChain). When it is full, the oldest are dropped and
// reported as lost, as are unreadable ones. If the disk cannot be written, it continues in memory,
// with less room, and says so in trouble(). Thread-safe.
class MessageRing {
public:
    // Identifies a message. Keys sort by age, across boots.
    struct Key {
        int boot = 0;
        std::int64_t sequence = 0;
        // NOLINTNEXTLINE(modernize-use-nullptr): a false positive of clang-tidy 14
        auto operator<=>(const Key&) const = default;
    };
    enum class Pile { Texts, Previews };

    static constexpr std::int64_t kMinBytes = std::int64_t{2} << 20;
    static constexpr std::int64_t kMaxMemoryBytes = std::int64_t{4} << 20;

    // Throws Error{Conflict} if another process uses the folder, Error{InvalidArgument} for
    // `max_bytes` below kMinBytes.
    MessageRing(const std::filesystem::path& folder, std::int64_t max_bytes, std::string boot_id);

    // Takes a message of this boot and returns its new sequence; ignores its boot and sequence.
    std::int64_t append(Message message);
    // Makes appended messages survive a power cut. Call it at least every second.
    void sync();

    const std::string& boot_id() const { return boot_id_; }
    std::string boot_id(Key key) const;
    // Returns the newest message of this boot.
    std::optional<Key> newest(MessageKind kind) const;
    // Returns the oldest message of a pile that is not in `taken`.
    std::optional<Key> oldest(Pile pile, const std::set<Key>& taken) const;
    bool is_of_this_boot(Key key) const { return key.boot == this_boot_; }
    // Returns nullopt if the message is gone or damaged, and reports it as lost.
    std::optional<Message> read(Key key);

    // Forgets messages that the server has on its disk.
    void committed(const std::string& boot_id, const SequenceRange& range);
    // Forgets a message that the server will never accept.
    void refused(Key key);

    // The first boot with lost messages that the server was not told about, and their ranges.
    struct Lost {
        std::string boot_id;
        std::vector<SequenceRange> ranges;  // at most kMaxLost of a report
    };
    std::optional<Lost> lost() const;
    std::vector<SequenceRange> lost_of(const std::string& boot_id) const;
    void reported_lost(const std::string& boot_id, const std::vector<SequenceRange>& ranges);

    std::size_t num_waiting() const;
    std::string trouble() const;  // "": the disk accepts messages

private:
    struct Entry {
        MessageKind kind = MessageKind::Status;
        SegmentChain::Place place;  // no segment: in memory
        std::string record;
    };
    using Entries = std::map<Key, Entry>;

    int boot_of(const std::string& boot_id);  // a new one for an unknown id
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
    std::vector<std::string> boots_;  // in order of time
    int this_boot_ = 0;
    std::array<Entries, 4> entries_;  // of each kind
    std::map<const SegmentFile*, std::int64_t> num_waiting_in_;
    std::map<int, LostRanges> lost_;
    std::int64_t memory_bytes_ = 0;
    std::string trouble_;
    std::chrono::steady_clock::time_point try_disk_at_;
    bool is_damaged_ = false;
    std::map<int, LostRanges> accounted_;  // at the start: the known outcomes of a boot's messages
    SegmentChain chain_;                   // last: its constructor fills the others
};

}  // namespace divemesh::sensor
