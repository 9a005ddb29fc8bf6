#include "worker/recording/mcap_container.hpp"

#include <libdeflate.h>
#include <limits>

#include "worker/base/observer.hpp"
#include "worker/recording/byte_cursor.hpp"
#include "worker/recording/unpack.hpp"

namespace divemesh::recording {
namespace {

// The records that matter here, by their opcodes.
constexpr std::uint8_t kFooter = 0x02;
constexpr std::uint8_t kSchema = 0x03;
constexpr std::uint8_t kChannel = 0x04;
constexpr std::uint8_t kMessage = 0x05;
constexpr std::uint8_t kChunk = 0x06;

constexpr std::int64_t kRecordHead_bytes = 9;  // opcode, length
// Records outside of chunks are read in runs of this size, so that a run is never all of the file.
constexpr std::int64_t kRun_bytes = std::int64_t{4} << 20U;
constexpr std::uint64_t kMaxTime_ns = std::numeric_limits<std::int64_t>::max();

struct McapRecord {
    std::uint8_t opcode = 0;
    std::string_view content;
};

// Takes the next record; nullopt at the end, and where the bytes end within it.
std::optional<McapRecord> take_record(ByteCursor& cursor) {
    const auto opcode = cursor.take<std::uint8_t>();
    const auto content = opcode ? cursor.take_sized<std::uint64_t>() : std::nullopt;
    if (!content) return std::nullopt;
    return McapRecord{*opcode, *content};
}

// A chunk as it is stored. `records` are cut where the file ends.
struct McapChunk {
    std::uint64_t num_bytes = 0;  // decompressed
    std::uint32_t crc = 0;        // of the decompressed bytes; 0: not known
    std::string_view codec;
    std::string_view records;
};

std::optional<McapChunk> parse_chunk(std::string_view record) {
    ByteCursor cursor(record);
    // The record's head and the times of its first and last message, which the messages state too.
    if (!cursor.take_bytes(kRecordHead_bytes + 2 * sizeof(std::uint64_t))) return std::nullopt;
    const auto num_bytes = cursor.take<std::uint64_t>();
    const auto crc = cursor.take<std::uint32_t>();
    const auto codec = cursor.take_sized<std::uint32_t>();
    const auto packed_bytes = cursor.take<std::uint64_t>();
    if (!num_bytes || !crc || !codec || !packed_bytes) return std::nullopt;
    return McapChunk{*num_bytes, *crc, *codec, cursor.rest().substr(0, *packed_bytes)};
}

OpenedBlock open_chunk(std::string_view record, bool is_cut) {
    const auto chunk = parse_chunk(record);
    if (!chunk) return {"", "the head of a chunk is damaged"};
    const auto codec = codec_from_text(chunk->codec);
    if (!codec || *codec == Codec::Bzip2)
        return {"", "a chunk is compressed in a way that is not known"};
    if (chunk->num_bytes > static_cast<std::uint64_t>(kMaxBlock_bytes))
        return {"",
                "a chunk states " + std::to_string(chunk->num_bytes) + " bytes, which is absurd"};
    Unpacked unpacked = unpack(*codec, chunk->records, chunk->num_bytes);
    if (is_cut) return {std::move(unpacked.bytes), ""};
    if (!unpacked.is_whole) return {"", "a chunk does not decompress to the size that it states"};
    const std::uint32_t crc = libdeflate_crc32(0, unpacked.bytes.data(), unpacked.bytes.size());
    if (chunk->crc != 0 && chunk->crc != crc) return {"", "the checksum of a chunk is wrong"};
    return {std::move(unpacked.bytes), ""};
}

// Returns how many bytes the first record takes, its head included; nullopt if there is no head, or
// it states more than `there` are.
std::optional<std::int64_t> record_bytes(std::string_view head, std::int64_t there) {
    ByteCursor cursor(head);
    const auto opcode = cursor.take<std::uint8_t>();
    const auto length = cursor.take<std::uint64_t>();
    if (!opcode || !length || there < kRecordHead_bytes) return std::nullopt;
    if (*length > static_cast<std::uint64_t>(there - kRecordHead_bytes)) return std::nullopt;
    return kRecordHead_bytes + static_cast<std::int64_t>(*length);
}

bool is_chunk(std::string_view record) {
    return !record.empty() && static_cast<std::uint8_t>(record.front()) == kChunk;
}

}  // namespace

McapContainer::McapContainer(InputFile file,
                             dive::FindingLog& findings,
                             const base::ProgressCallback& progress)
    : ChunkedContainer(std::move(file)) {
    learn_summary();
    scan(findings, progress);
}

// Learns the channels from the end of the file, where it repeats them: their first place may be in
// a chunk that is damaged.
void McapContainer::learn_summary() {
    constexpr std::int64_t kFooter_bytes = kRecordHead_bytes + 20;  // two places and a CRC
    const std::int64_t end = file_.size_bytes() - std::ssize(kMcapMagic) - kFooter_bytes;
    if (end < 0) return;
    const std::string footer = file_.read(end, kFooter_bytes);
    ByteCursor cursor(footer);
    const auto opcode = cursor.take<std::uint8_t>();
    cursor.take<std::uint64_t>();
    const auto begin = cursor.take<std::uint64_t>();
    if (opcode != kFooter || !begin || *begin == 0) return;
    if (*begin > static_cast<std::uint64_t>(end)) return;
    const auto offset = static_cast<std::int64_t>(*begin);
    if (end - offset <= kMaxBlock_bytes) learn(file_.read(offset, end - offset));
}

void McapContainer::scan(dive::FindingLog& findings, const base::ProgressCallback& progress) {
    const std::int64_t size = file_.size_bytes();
    Block run;  // of records outside of chunks
    const auto end_run = [&] {
        if (run.size() > 0) add(run, findings);
        run = {};
    };
    for (std::int64_t at = std::ssize(kMcapMagic);;) {
        progress({"import", 0.5 * static_cast<double>(at) / static_cast<double>(size)});
        const std::string head = file_.read(at, kRecordHead_bytes);
        const auto num_bytes = record_bytes(head, size - at);
        if (!num_bytes) {
            end_run();
            if (is_chunk(head)) add({0, at, size}, findings);
            return report_cut(at, findings);
        }
        const auto opcode = static_cast<std::uint8_t>(head.front());
        if (opcode == kMessage || opcode == kSchema || opcode == kChannel) {
            if (run.size() + *num_bytes > kRun_bytes) end_run();
            if (run.size() == 0) run.begin = at;
            run.end = at + *num_bytes;
        } else {
            end_run();
        }
        if (opcode == kChunk) add({0, at, at + *num_bytes}, findings);
        if (opcode == kFooter) return;
        at += *num_bytes;
    }
}

OpenedBlock McapContainer::open(std::string bytes) const {
    if (!is_chunk(bytes)) return {std::move(bytes), ""};
    return open_chunk(bytes, !record_bytes(bytes, std::ssize(bytes)));
}

void McapContainer::learn(std::string_view records) {
    ByteCursor cursor(records);
    while (const auto record = take_record(cursor)) {
        if (record->opcode == kSchema) learn_schema(record->content);
        if (record->opcode == kChannel) learn_channel(record->content);
    }
}

void McapContainer::learn_schema(std::string_view content) {
    ByteCursor cursor(content);
    const auto number = cursor.take<std::uint16_t>();
    const auto name = cursor.take_sized<std::uint32_t>();
    if (number && name && name->size() <= kMaxName_bytes) schemas_.emplace(*number, *name);
}

void McapContainer::learn_channel(std::string_view content) {
    ByteCursor cursor(content);
    const auto number = cursor.take<std::uint16_t>();
    const auto schema = cursor.take<std::uint16_t>();
    const auto name = cursor.take_sized<std::uint32_t>();
    const auto encoding = cursor.take_sized<std::uint32_t>();
    if (!number || !schema || !name || !encoding || channels_.contains(*number)) return;
    const auto type = schemas_.find(*schema);
    const auto serialization = *encoding == "ros1"  ? Serialization::Ros1
                               : *encoding == "cdr" ? Serialization::Cdr
                                                    : Serialization::Unknown;
    const auto topic = topic_of(*name, type == schemas_.end() ? "" : type->second, serialization);
    if (topic) channels_.emplace(*number, *topic);
}

BlockContents McapContainer::parse(std::string bytes) const {
    BlockContents contents;
    ByteCursor records(bytes);
    while (const auto record = take_record(records)) {
        if (record->opcode != kMessage) continue;
        ByteCursor cursor(record->content);
        const auto channel = cursor.take<std::uint16_t>();
        cursor.take<std::uint32_t>();  // the place in the sequence
        const auto log_time_ns = cursor.take<std::uint64_t>();
        const auto publish_time_ns = cursor.take<std::uint64_t>();
        if (!publish_time_ns || *log_time_ns > kMaxTime_ns) continue;
        const auto topic = channels_.find(*channel);
        if (topic == channels_.end()) continue;
        contents.messages.push_back({topic->second,
                                     static_cast<std::int64_t>(*log_time_ns),
                                     static_cast<std::size_t>(cursor.rest().data() - bytes.data()),
                                     cursor.rest().size()});
    }
    contents.bytes = std::move(bytes);
    return contents;
}

}  // namespace divemesh::recording
