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

// The ring on disk: numbered segments, appended at the end and removed at the beginning. Every
// record belongs to a boot. Use it from one thread at a time, except sync().
class SegmentChain {
public:
    // The place of a record; it keeps its segment readable.
    struct Place {
        std::shared_ptr<SegmentFile> segment;
        std::int64_t offset = 0;
    };
    // Callbacks for the records found at the start. The kinds of records are in the .cpp.
    struct Found {
        std::function<void(const std::string& boot_id, const Place& place, std::string_view record)>
            message;
        std::function<void(const std::string& boot_id, const SequenceRange& range)> committed;
        std::function<void(const std::string& boot_id, const SequenceRange& range)> lost;
        std::function<void()> damaged;  // some of the data is unreadable
    };

    // Reads what is in `folder`, which may be missing. Throws Error{Conflict} if another process
    // has it; leaves unreadable data where it is.
    SegmentChain(std::filesystem::path folder, std::int64_t max_bytes, const Found& found);
    ~SegmentChain();
    SegmentChain(const SegmentChain&) = delete;
    SegmentChain& operator=(const SegmentChain&) = delete;

    // Each throws Error{OutOfSpace} or Error{Unavailable} if the disk does not accept the bytes.
    Place append_message(const std::string& boot_id, std::string_view record);
    void append_committed(const std::string& boot_id, const SequenceRange& range);
    void append_lost(const std::string& boot_id, const SequenceRange& range);
    static std::string read_message(const Place& place);  // throws Error{BadData}

    // Returns whether another record of that size only fits after removing the first segment.
    bool is_full(std::size_t record_bytes) const;
    std::shared_ptr<SegmentFile> first() const;  // null: no segment
    bool has_only_one() const { return segments_.size() == 1; }
    // Removes the first segment and its file. Its records stay readable through their places.
    void remove_first();
    // Makes the next record begin a new segment: the last one may be removed, or is damaged.
    void end_segment() { is_open_ = false; }

    // Makes appended records survive a power cut; any thread. Throws as append_message() does.
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
    std::string boot_of_last_;  // the boot of the last segment's records
    bool is_open_ = false;      // this process may write to the last segment
    std::mutex mutex_;          // guards the members below
    std::vector<std::shared_ptr<SegmentFile>> unsynced_;
    bool is_folder_unsynced_ = false;
};

}  // namespace divemesh::sensor
