#include "sensor/ring/segment_chain.hpp"

#include <algorithm>
#include <charconv>
#include <fcntl.h>
#include <iomanip>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <sys/file.h>
#include <unistd.h>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The first byte of a record. Messages belong to the boot of the last kBoot record before them.
constexpr char kBoot = 'B';
constexpr char kMessage = 'M';
constexpr char kCommitted = 'C';
constexpr char kLost = 'L';

constexpr std::int64_t kMinSegments = 16;  // segments that share the room
constexpr std::int64_t kMinSegmentBytes = std::int64_t{64} << 10;

constexpr std::string_view kPrefix = "segment-";
constexpr std::string_view kSuffix = ".ring";

std::string name_of(std::int64_t number) {
    std::ostringstream name;
    name << kPrefix << std::setw(12) << std::setfill('0') << number << kSuffix;
    return name.str();
}

// Returns nullopt if the name is not that of a segment.
std::optional<std::int64_t> number_of(const std::string& name) {
    if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) return std::nullopt;
    const std::string_view digits = std::string_view(name).substr(
        kPrefix.size(), name.size() - kPrefix.size() - kSuffix.size());
    std::int64_t number = -1;
    const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    if (end != digits.data() + digits.size() || number < 0) return std::nullopt;
    return number;
}

std::string range_text(const std::string& boot_id, const SequenceRange& range) {
    return json{{"boot_id", boot_id}, {"first", range.first}, {"last", range.last}}.dump();
}

template <typename Tell>
void read_range(std::string_view text, const Tell& tell) {
    const json range = json::parse(text, nullptr, false);
    if (!range.is_object()) return;
    const SequenceRange read{range.value("first", std::int64_t{0}),
                             range.value("last", std::int64_t{-1})};
    if (read.first >= 0 && read.first <= read.last) tell(range.value("boot_id", ""), read);
}

void sync_folder(const fs::path& folder) {
    const FileDescriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (descriptor.is_open()) ::fsync(descriptor.get());
}

}  // namespace

SegmentChain::SegmentChain(fs::path folder, std::int64_t max_bytes, const Found& found)
    : folder_(std::move(folder)), max_bytes_(max_bytes) {
    lock_folder();
    std::map<std::int64_t, fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored))
        if (const auto number = number_of(entry.path().filename().string()))
            files.emplace(*number, entry.path());
    for (const auto& [number, path] : files) {
        load(path, found);
        next_number_ = number + 1;
    }
}

SegmentChain::~SegmentChain() {
    try {
        sync();
    } catch (const Error&) {
        return;  // a failed write was reported as trouble before
    }
}

void SegmentChain::lock_folder() {
    std::error_code ignored;
    fs::create_directories(folder_, ignored);
    lock_ = FileDescriptor(::open((folder_ / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (lock_.is_open() && ::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0)
        throw Error(ErrorCode::Conflict,
                    folder_.string() +
                        " is used by another agent: stop it, or choose another "
                        "folder");
}

void SegmentChain::load(const fs::path& path, const Found& found) {
    std::string boot_id;
    std::vector<std::pair<std::int64_t, std::string>> messages;
    const auto read = [&](std::int64_t offset, std::string_view payload) {
        const std::string_view rest = payload.substr(1);
        if (payload[0] == kBoot) boot_id = rest;
        if (payload[0] == kMessage) messages.emplace_back(offset, rest);
        // In the order of the file: a message precedes the record of its commit.
        if (payload[0] == kCommitted || payload[0] == kLost) messages.emplace_back(-1, payload);
    };
    try {
        const auto segment = std::make_shared<SegmentFile>(SegmentFile::open(path, read));
        segments_.push_back(segment);
        size_bytes_ += segment->size_bytes();
        if (segment->is_damaged()) found.damaged();
        for (const auto& [offset, record] : messages) {
            if (offset >= 0 && boot_id.empty()) continue;
            if (offset >= 0)
                found.message(boot_id, {segment, offset}, record);
            else
                read_range(std::string_view(record).substr(1),
                           record[0] == kLost ? found.lost : found.committed);
        }
    } catch (const Error& error) {
        std::error_code ignored;  // the power failed before its first bytes were on disk
        if (error.code() == ErrorCode::BadData) fs::remove(path, ignored);
    }
}

SegmentChain::Place SegmentChain::append_message(const std::string& boot_id,
                                                 std::string_view record) {
    if (boot_of_last_ != boot_id) end_segment();
    boot_of_last_ = boot_id;
    append(kMessage, record);
    return {segments_.back(),
            segments_.back()->size_bytes() - SegmentFile::kHeadBytes - 1 -
                static_cast<std::int64_t>(record.size())};
}

void SegmentChain::append_committed(const std::string& boot_id, const SequenceRange& range) {
    append(kCommitted, range_text(boot_id, range));
}

void SegmentChain::append_lost(const std::string& boot_id, const SequenceRange& range) {
    append(kLost, range_text(boot_id, range));
}

std::string SegmentChain::read_message(const Place& place) {
    return place.segment->read(place.offset).substr(1);
}

void SegmentChain::append(char word, std::string_view payload) {
    const std::int64_t max_segment_bytes = std::max(kMinSegmentBytes, max_bytes_ / kMinSegments);
    if (is_open_ &&
        (segments_.back()->size_bytes() >= max_segment_bytes || segments_.back()->is_removed()))
        is_open_ = false;
    if (!is_open_) begin_segment();
    std::string record(1, word);
    const std::int64_t before = segments_.back()->size_bytes();
    segments_.back()->append(record.append(payload));
    size_bytes_ += segments_.back()->size_bytes() - before;
    const std::lock_guard lock(mutex_);
    if (unsynced_.empty() || unsynced_.back() != segments_.back())
        unsynced_.push_back(segments_.back());
}

void SegmentChain::begin_segment() {
    std::error_code failure;
    fs::create_directories(folder_, failure);
    auto segment =
        std::make_shared<SegmentFile>(SegmentFile::create(folder_ / name_of(next_number_)));
    ++next_number_;
    const std::string record = kBoot + boot_of_last_;
    try {
        // Twice, because without it the messages would have no boot.
        for (int i = 0; i < 2; ++i) segment->append(record);
    } catch (const Error&) {
        fs::remove(segment->path(), failure);
        throw;
    }
    size_bytes_ += segment->size_bytes();
    segments_.push_back(std::move(segment));
    is_open_ = true;
    const std::lock_guard lock(mutex_);
    is_folder_unsynced_ = true;
}

bool SegmentChain::is_full(std::size_t record_bytes) const {
    constexpr std::size_t kHeads = 256;  // of the record, and of a segment that may begin with it
    return !segments_.empty() &&
           size_bytes_ + static_cast<std::int64_t>(record_bytes + kHeads) > max_bytes_;
}

std::shared_ptr<SegmentFile> SegmentChain::first() const {
    return segments_.empty() ? nullptr : segments_.front();
}

void SegmentChain::remove_first() {
    if (segments_.size() == 1) end_segment();
    const auto segment = segments_.front();
    segments_.pop_front();
    size_bytes_ -= segment->size_bytes();
    std::error_code ignored;  // on a read-only disk it stays until a later start
    fs::remove(segment->path(), ignored);
    const std::lock_guard lock(mutex_);
    std::erase(unsynced_, segment);
}

void SegmentChain::sync() {
    std::vector<std::shared_ptr<SegmentFile>> segments;
    bool is_folder_unsynced = false;
    {
        const std::lock_guard lock(mutex_);
        segments.swap(unsynced_);
        std::swap(is_folder_unsynced, is_folder_unsynced_);
    }
    for (const auto& segment : segments) segment->sync();
    if (is_folder_unsynced) sync_folder(folder_);
}

}  // namespace divemesh::sensor
