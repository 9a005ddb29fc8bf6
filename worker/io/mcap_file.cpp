#include "worker/io/mcap_file.hpp"

#include <algorithm>

namespace divemesh::io {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kChunk_bytes = 4U << 20U;  // at which a chunk is written

// The records of the format by their opcodes.
constexpr std::uint8_t kHeader = 0x01;
constexpr std::uint8_t kFooter = 0x02;
constexpr std::uint8_t kSchema = 0x03;
constexpr std::uint8_t kChannel = 0x04;
constexpr std::uint8_t kMessage = 0x05;
constexpr std::uint8_t kChunk = 0x06;
constexpr std::uint8_t kMessageIndex = 0x07;
constexpr std::uint8_t kChunkIndex = 0x08;
constexpr std::uint8_t kStatistics = 0x0b;
constexpr std::uint8_t kMetadata = 0x0c;
constexpr std::uint8_t kMetadataIndex = 0x0d;
constexpr std::uint8_t kSummaryOffset = 0x0e;
constexpr std::uint8_t kDataEnd = 0x0f;

template <typename Size>
void put_sized(Record& record, std::string_view bytes) {
    record.put(static_cast<Size>(bytes.size()));
    record.put_field(bytes, bytes.size());
}

void put_string(Record& record, std::string_view text) { put_sized<std::uint32_t>(record, text); }

void put_strings(Record& record, const std::map<std::string, std::string>& texts) {
    Record pairs;
    for (const auto& [key, value] : texts) {
        put_string(pairs, key);
        put_string(pairs, value);
    }
    put_string(record, pairs.bytes());
}

std::string record_bytes(std::uint8_t opcode, std::string_view content) {
    Record record;
    record.put(opcode);
    put_sized<std::uint64_t>(record, content);
    return std::string(record.bytes());
}

void append(Record& record, std::string_view bytes) { record.put_field(bytes, bytes.size()); }

}  // namespace

McapFile::McapFile(const std::filesystem::path& file) : file_(file) {
    put(kMagic);
    Record header;
    put_string(header, "");  // profile: none
    put_string(header, "divemesh");
    put_record(kHeader, header);
}

std::uint16_t McapFile::add_channel(const std::string& topic,
                                    const std::string& schema_name,
                                    const nlohmann::json& schema) {
    const auto number = static_cast<std::uint16_t>(channels_.size());
    const auto schema_number = static_cast<std::uint16_t>(number + 1);  // 0 is that of none
    Record stored;
    stored.put(schema_number);
    put_string(stored, schema_name);
    put_string(stored, "jsonschema");
    put_string(stored, schema.dump());
    Record channel;
    channel.put(number);
    channel.put(schema_number);
    put_string(channel, topic);
    put_string(channel, "json");
    put_strings(channel, {});
    put_record(kSchema, stored);
    put_record(kChannel, channel);
    schemas_.push_back(std::move(stored));
    channels_.push_back(std::move(channel));
    num_messages_.push_back(0);
    return number;
}

void McapFile::add_message(std::uint16_t channel,
                           std::int64_t timestamp_ns,
                           const nlohmann::json& message) {
    const auto time_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(timestamp_ns, 0));
    if (chunk_messages_.empty()) chunk_span_ = {time_ns, time_ns};
    chunk_span_ = {std::min(chunk_span_.begin_ns, time_ns), std::max(chunk_span_.end_ns, time_ns)};
    chunk_messages_[channel].emplace_back(time_ns, chunk_.size_bytes());
    Record content;
    content.put(channel);
    content.put(static_cast<std::uint32_t>(num_messages_[channel]++));
    content.put(time_ns);  // when it was recorded
    content.put(time_ns);  // when it was published
    append(content, message.dump());
    append(chunk_, record_bytes(kMessage, content.bytes()));
    if (chunk_.size_bytes() >= kChunk_bytes) flush_chunk();
}

void McapFile::commit(const std::string& name, const std::map<std::string, std::string>& texts) {
    flush_chunk();
    const std::uint64_t metadata_at = size_bytes_;
    Record metadata;
    put_string(metadata, name);
    put_strings(metadata, texts);
    put_record(kMetadata, metadata);
    const std::uint64_t metadata_bytes = size_bytes_ - metadata_at;
    Record end;
    end.put(section_crc_.value());
    put_record(kDataEnd, end);
    section_crc_ = {};
    put_summary(metadata_at, metadata_bytes, name);
    put(kMagic);
    file_.commit();
}

void McapFile::put(std::string_view bytes) {
    file_.write(bytes);
    section_crc_.add(bytes);
    size_bytes_ += bytes.size();
}

void McapFile::put_record(std::uint8_t opcode, const Record& content) {
    put(record_bytes(opcode, content.bytes()));
}

// Writes the chunk and, behind it, where the messages of each channel are in it.
void McapFile::flush_chunk() {
    if (chunk_messages_.empty()) return;
    span_ = chunk_indices_.empty() ? chunk_span_
                                   : TimeSpan{std::min(span_.begin_ns, chunk_span_.begin_ns),
                                              std::max(span_.end_ns, chunk_span_.end_ns)};
    Crc32 crc;
    crc.add(chunk_.bytes());
    Record chunk;
    chunk.put(chunk_span_.begin_ns);
    chunk.put(chunk_span_.end_ns);
    chunk.put(std::uint64_t{chunk_.size_bytes()});
    chunk.put(crc.value());
    put_string(chunk, "");  // no compression
    put_sized<std::uint64_t>(chunk, chunk_.bytes());
    const std::uint64_t chunk_at = size_bytes_;
    put_record(kChunk, chunk);
    const std::uint64_t indices_at = size_bytes_;
    Record offsets;
    for (auto& [channel, messages] : chunk_messages_) {
        offsets.put(channel);
        offsets.put(size_bytes_);
        std::sort(messages.begin(), messages.end());
        Record entries;
        for (const auto& [time_ns, offset] : messages) {
            entries.put(time_ns);
            entries.put(offset);
        }
        Record index;
        index.put(channel);
        put_string(index, entries.bytes());
        put_record(kMessageIndex, index);
    }
    Record& index = chunk_indices_.emplace_back();
    index.put(chunk_span_.begin_ns);
    index.put(chunk_span_.end_ns);
    index.put(chunk_at);
    index.put(indices_at - chunk_at);
    put_string(index, offsets.bytes());
    index.put(size_bytes_ - indices_at);
    put_string(index, "");
    index.put(std::uint64_t{chunk_.size_bytes()});
    index.put(std::uint64_t{chunk_.size_bytes()});
    chunk_ = {};
    chunk_messages_.clear();
}

void McapFile::put_summary(std::uint64_t metadata_at,
                           std::uint64_t metadata_bytes,
                           const std::string& name) {
    const std::uint64_t summary_at = size_bytes_;
    Record groups;  // what the summary offset section tells
    const auto put_group = [&](std::uint8_t opcode, const std::vector<Record>& records) {
        const std::uint64_t begin = size_bytes_;
        for (const Record& record : records) put_record(opcode, record);
        if (records.empty()) return;
        Record group;
        group.put(opcode);
        group.put(begin);
        group.put(size_bytes_ - begin);
        append(groups, record_bytes(kSummaryOffset, group.bytes()));
    };
    put_group(kSchema, schemas_);
    put_group(kChannel, channels_);
    Record counts;
    std::uint64_t num_messages = 0;
    for (std::size_t channel = 0; channel < num_messages_.size(); ++channel) {
        counts.put(static_cast<std::uint16_t>(channel));
        counts.put(num_messages_[channel]);
        num_messages += num_messages_[channel];
    }
    Record statistics;
    statistics.put(num_messages);
    statistics.put(static_cast<std::uint16_t>(schemas_.size()));
    statistics.put(static_cast<std::uint32_t>(channels_.size()));
    statistics.put(std::uint32_t{0});  // attachments
    statistics.put(std::uint32_t{1});  // metadata
    statistics.put(static_cast<std::uint32_t>(chunk_indices_.size()));
    statistics.put(span_.begin_ns);
    statistics.put(span_.end_ns);
    put_string(statistics, counts.bytes());
    put_group(kStatistics, {statistics});
    put_group(kChunkIndex, chunk_indices_);
    Record metadata_index;
    metadata_index.put(metadata_at);
    metadata_index.put(metadata_bytes);
    put_string(metadata_index, name);
    put_group(kMetadataIndex, {metadata_index});
    const std::uint64_t offsets_at = size_bytes_;
    put(groups.bytes());
    // The checksum covers the footer up to itself.
    Record footer;
    footer.put(summary_at);
    footer.put(offsets_at);
    Record head;
    head.put(kFooter);
    head.put(std::uint64_t{footer.size_bytes() + sizeof(std::uint32_t)});
    section_crc_.add(head.bytes());
    section_crc_.add(footer.bytes());
    footer.put(section_crc_.value());
    put_record(kFooter, footer);
}

}  // namespace divemesh::io
