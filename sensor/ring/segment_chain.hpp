#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/file_descriptor.hpp"
#include "schemas/sequence_ranges.hpp"
#include "sensor/ring/segment_file.hpp"

namespace divemesh::sensor {

// The ring on disk: segments in the order of their numbers, written to at the end, taken away at
// the begin. Every record is told with the boot that it is of. One thread at a time, but for
// sync().
class SegmentChain {
public:
    // What is at a place, alive for as long as somebody holds it.
    struct Place {
        std::shared_ptr<SegmentFile> segment;
        std::int64_t offset = 0;
    };
    // A record as it is found at the start. Word: what kind of record; see the .cpp.
    struct Found {
        std::function<void(const std::string& boot_id, const Place& place, std::string_view record)>
            message;
        std::function<void(const std::string& boot_id, const SequenceRange& range)> committed;
        std::function<void(const std::string& boot_id, const SequenceRange& range)> lost;
        std::function<void()> damaged;  // there was more than can be read
    };

    // Reads what is in `folder`, which need not be there. Throws Error{Conflict} when another
    // process has it; what cannot be read is left where it is.
    SegmentChain(std::filesystem::path folder, std::int64_t max_bytes, const Found& found);
    ~SegmentChain();
    SegmentChain(const SegmentChain&) = delete;
    SegmentChain& operator=(const SegmentChain&) = delete;

    // Each throws Error{OutOfSpace} or Error{Unavailable} when the disk does not take it.
    Place append_message(const std::string& boot_id, std::string_view record);
    void append_committed(const std::string& boot_id, const SequenceRange& range);
    void append_lost(const std::string& boot_id, const SequenceRange& range);
    static std::string read_message(const Place& place);  // throws Error{BadData}

    // There is no room for another record of that size without taking the first segment away.
    bool is_full(std::size_t record_bytes) const;
    std::shared_ptr<SegmentFile> first() const;  // null: none
    bool has_only_one() const { return segments_.size() == 1; }
    // With its file. What was in it can still be read by those who hold a place in it.
    void remove_first();
    // What is appended next begins a new segment: the last one can be taken away or is not good.
    void end_segment() { is_open_ = false; }

    // What was appended survives a power cut; any thread. Throws as append_message().
    void sync();

private:
    void append(char word, std::string_view payload);
    void begin_segment();
    void load(const std::filesystem::path& path, const Found& found);
    void lock_folder();

    std::filesystem::path folder_;
    std::int64_t max_bytes_;
    FileDescriptor lock_;
    std::deque<std::shared_ptr<SegmentFile>> segments_;
    std::int64_t next_number_ = 0;
    std::int64_t size_bytes_ = 0;
    std::string boot_of_last_;  // that the last segment's records are of
    bool is_open_ = false;      // the last segment is ours to write to
    std::mutex mutex_;          // of what follows
    std::vector<std::shared_ptr<SegmentFile>> unsynced_;
    bool is_folder_unsynced_ = false;
};

}  // namespace divemesh::sensor
