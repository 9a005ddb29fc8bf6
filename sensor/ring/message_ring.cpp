#include "sensor/ring/message_ring.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "schemas/error.hpp"
#include "schemas/sensor_message.hpp"

namespace divemesh::sensor {
namespace {

constexpr std::chrono::seconds kDiskPause{10};  // until a failed disk is tried again

std::int64_t checked(std::int64_t max_bytes) {
    if (max_bytes < MessageRing::kMinBytes)
        throw Error(ErrorCode::InvalidArgument, "the ring is too small: give at least 2 MiB");
    return max_bytes;
}

std::vector<MessageKind> kinds_of(MessageRing::Pile pile) {
    if (pile == MessageRing::Pile::Previews) return {MessageKind::Preview};
    return {MessageKind::Hello, MessageKind::Status, MessageKind::Outcome};
}

}  // namespace

MessageRing::MessageRing(const std::filesystem::path& folder,
                         std::int64_t max_bytes,
                         std::string boot_id)
    : boot_id_(std::move(boot_id)), chain_(folder, checked(max_bytes), loader()) {
    lose_what_is_missing();
    this_boot_ = boot_of(boot_id_);
    remove_finished_segments();
}

SegmentChain::Found MessageRing::loader() {
    SegmentChain::Found found;
    found.message = [this](const std::string& boot_id, const auto& place, std::string_view record) {
        try {
            const Message message = message_of_record(record, boot_id);
            const Key key{boot_of(boot_id), message.sequence};
            const Entry entry{message.kind, place, ""};
            accounted_[key.boot].add({key.sequence, key.sequence});
            if (entries_of(message.kind).emplace(key, entry).second)
                ++num_waiting_in_[place.segment.get()];
        } catch (const Error&) {
            return;  // of another version: the bytes are intact, but no message
        }
    };
    found.committed = [this](const std::string& boot_id, const SequenceRange& range) {
        const int boot = boot_of(boot_id);
        accounted_[boot].add(range);
        for (Entries& entries : entries_)
            for (auto entry = entries.lower_bound({boot, range.first});
                 entry != entries.end() && entry->first <= Key{boot, range.last};)
                forget(entry++, entries);
    };
    found.lost = [this](const std::string& boot_id, const SequenceRange& range) {
        lost_[boot_of(boot_id)].add(range);
        accounted_[boot_of(boot_id)].add(range);
    };
    found.damaged = [this] { is_damaged_ = true; };
    return found;
}

// Reports messages as lost that have no record on the disk, although it has later ones of their
// boot: they were damaged, or in memory when the power failed. Messages before the first known one
// were committed, and the records of that were removed with their segments, unless something is
// damaged. Reporting a message as lost that the server has changes nothing.
void MessageRing::lose_what_is_missing() {
    for (const auto& [boot, accounted] : accounted_) {
        const auto known = accounted.first(std::numeric_limits<std::size_t>::max());
        LostRanges missing;
        missing.add({is_damaged_ ? 0 : known.front().first, known.back().last});
        for (const SequenceRange& range : known) missing.remove(range);
        for (const SequenceRange& range : missing.first(std::numeric_limits<std::size_t>::max()))
            lost_[boot].add(range);
    }
    accounted_.clear();
}

int MessageRing::boot_of(const std::string& boot_id) {
    const auto found = std::find(boots_.rbegin(), boots_.rend(), boot_id);
    if (found != boots_.rend()) return static_cast<int>(boots_.rend() - found) - 1;
    boots_.push_back(boot_id);
    return static_cast<int>(boots_.size()) - 1;
}

std::string MessageRing::boot_id(Key key) const {
    const std::lock_guard lock(mutex_);
    return boots_.at(static_cast<std::size_t>(key.boot));
}

std::int64_t MessageRing::append(Message message) {
    const std::lock_guard lock(mutex_);
    message.boot_id = boot_id_;
    message.sequence = next_sequence_++;
    store({this_boot_, message.sequence}, message);
    return message.sequence;
}

void MessageRing::store(Key key, const Message& message) {
    std::string record = to_record(message);
    if (disk_is_given_up()) return keep_in_memory(key, message.kind, std::move(record));
    try {
        make_room(record.size());
        const auto place = chain_.append_message(boot_id_, record);
        entries_of(message.kind).emplace(key, Entry{message.kind, place, ""});
        ++num_waiting_in_[place.segment.get()];
        trouble_.clear();
    } catch (const Error& error) {
        disk_failed(error);
        keep_in_memory(key, message.kind, std::move(record));
    }
}

bool MessageRing::disk_is_given_up() const {
    return !trouble_.empty() && std::chrono::steady_clock::now() < try_disk_at_;
}

void MessageRing::disk_failed(const std::exception& failure) {
    trouble_ = failure.what();
    try_disk_at_ = std::chrono::steady_clock::now() + kDiskPause;
    chain_.end_segment();
}

void MessageRing::keep_in_memory(Key key, MessageKind kind, std::string record) {
    memory_bytes_ += static_cast<std::int64_t>(record.size());
    entries_of(kind).emplace(key, Entry{kind, {}, std::move(record)});
    while (memory_bytes_ > kMaxMemoryBytes) drop_from_memory();
}

// Drops previews before texts.
void MessageRing::drop_from_memory() {
    for (const MessageKind kind :
         {MessageKind::Preview, MessageKind::Status, MessageKind::Outcome, MessageKind::Hello}) {
        Entries& entries = entries_of(kind);
        const auto entry = std::find_if(entries.begin(), entries.end(), [](const auto& one) {
            return !one.second.place.segment;
        });
        if (entry == entries.end()) continue;
        const Key key = entry->first;
        forget(entry, entries);
        return lose(key);
    }
}

void MessageRing::make_room(std::size_t record_bytes) {
    bool has_lost = false;
    while (chain_.is_full(record_bytes)) {
        has_lost = true;
        drop_first_segment();
    }
    if (has_lost) write_down_lost();
}

void MessageRing::drop_first_segment() {
    const auto segment = chain_.first();
    for (Entries& entries : entries_)
        for (auto entry = entries.begin(); entry != entries.end();) {
            const auto next = std::next(entry);
            if (entry->second.place.segment == segment) {
                const Key key = entry->first;
                forget(entry, entries);
                lose(key);
            }
            entry = next;
        }
    num_waiting_in_.erase(segment.get());
    chain_.remove_first();
}

void MessageRing::lose(Key key) { lost_[key.boot].add({key.sequence, key.sequence}); }

// Writes the losses again, because the segment with their records may have been removed.
void MessageRing::write_down_lost() {
    for (const auto& [boot, ranges] : lost_)
        for (const SequenceRange& range : ranges.first(kMaxLost))
            chain_.append_lost(boots_.at(static_cast<std::size_t>(boot)), range);
}

void MessageRing::forget(Entries::iterator entry, Entries& entries) {
    if (const auto& segment = entry->second.place.segment)
        --num_waiting_in_[segment.get()];
    else
        memory_bytes_ -= static_cast<std::int64_t>(entry->second.record.size());
    entries.erase(entry);
}

void MessageRing::sync() {
    try {
        chain_.sync();
    } catch (const Error& error) {
        const std::lock_guard lock(mutex_);
        disk_failed(error);
    }
}

std::optional<MessageRing::Key> MessageRing::newest(MessageKind kind) const {
    const std::lock_guard lock(mutex_);
    const Entries& entries = entries_.at(static_cast<std::size_t>(kind));
    if (entries.empty() || entries.rbegin()->first.boot != this_boot_) return std::nullopt;
    return entries.rbegin()->first;
}

std::optional<MessageRing::Key> MessageRing::oldest(Pile pile, const std::set<Key>& taken) const {
    const std::lock_guard lock(mutex_);
    std::optional<Key> oldest;
    for (const MessageKind kind : kinds_of(pile))
        for (const auto& [key, entry] : entries_.at(static_cast<std::size_t>(kind))) {
            if (taken.contains(key)) continue;
            if (!oldest || key < *oldest) oldest = key;
            break;
        }
    return oldest;
}

std::optional<Message> MessageRing::read(Key key) {
    const std::lock_guard lock(mutex_);
    for (Entries& entries : entries_) {
        const auto entry = entries.find(key);
        if (entry == entries.end()) continue;
        try {
            const auto& [kind, place, record] = entry->second;
            return message_of_record(place.segment ? SegmentChain::read_message(place) : record,
                                     boots_.at(static_cast<std::size_t>(key.boot)));
        } catch (const Error& error) {
            trouble_ = error.what();
            forget(entry, entries);
            lose(key);
        }
    }
    return std::nullopt;
}

void MessageRing::committed(const std::string& boot_id, const SequenceRange& range) {
    const std::lock_guard lock(mutex_);
    const auto known = std::find(boots_.begin(), boots_.end(), boot_id);
    if (known == boots_.end()) return;
    const int boot = static_cast<int>(known - boots_.begin());
    bool is_on_disk = false;
    for (Entries& entries : entries_)
        for (auto entry = entries.lower_bound({boot, range.first});
             entry != entries.end() && entry->first <= Key{boot, range.last};) {
            is_on_disk = is_on_disk || entry->second.place.segment;
            forget(entry++, entries);
        }
    remove_finished_segments();
    if (!is_on_disk || disk_is_given_up() || !chain_.first()) return;
    try {
        make_room(0);
        chain_.append_committed(boot_id, range);
    } catch (const Error& error) {
        disk_failed(error);  // it is sent again after the next start, which changes nothing
    }
}

// Removes segments in their order: records in one segment about messages in earlier ones are needed
// as long as those exist.
void MessageRing::remove_finished_segments() {
    while (const auto segment = chain_.first()) {
        if (num_waiting_in_[segment.get()] > 0 || chain_.has_only_one()) return;
        num_waiting_in_.erase(segment.get());
        chain_.remove_first();
    }
}

void MessageRing::refused(Key key) {
    const std::lock_guard lock(mutex_);
    for (Entries& entries : entries_)
        if (const auto entry = entries.find(key); entry != entries.end()) {
            forget(entry, entries);
            lose(key);
        }
}

std::optional<MessageRing::Lost> MessageRing::lost() const {
    const std::lock_guard lock(mutex_);
    for (const auto& [boot, ranges] : lost_)
        if (!ranges.empty())
            return Lost{boots_.at(static_cast<std::size_t>(boot)), ranges.first(kMaxLost)};
    return std::nullopt;
}

std::vector<SequenceRange> MessageRing::lost_of(const std::string& boot_id) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [boot, ranges] : lost_)
        if (boots_.at(static_cast<std::size_t>(boot)) == boot_id) return ranges.first(kMaxLost);
    return {};
}

void MessageRing::reported_lost(const std::string& boot_id,
                                const std::vector<SequenceRange>& ranges) {
    const std::lock_guard lock(mutex_);
    for (auto& [boot, lost] : lost_)
        if (boots_.at(static_cast<std::size_t>(boot)) == boot_id)
            for (const SequenceRange& range : ranges) lost.remove(range);
}

std::size_t MessageRing::num_waiting() const {
    const std::lock_guard lock(mutex_);
    std::size_t count = 0;
    for (const Entries& entries : entries_) count += entries.size();
    return count;
}

std::string MessageRing::trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
}

}  // namespace divemesh::sensor
