#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "worker/base/atomic_file.hpp"
#include "worker/io/crc32.hpp"
#include "worker/io/record.hpp"

namespace divemesh::io {

// A recording in the format of mcap.dev (version 0) that is written message by message: JSON
// messages with JSON schemas, in chunks without compression, with indices and checksums. Throws as
// AtomicFile does.
class McapFile {
public:
    explicit McapFile(const std::filesystem::path& file);

    // Adds a topic whose messages are of a schema. Returns its number.
    std::uint16_t add_channel(const std::string& topic,
                              const std::string& schema_name,
                              const nlohmann::json& schema);
    void add_message(std::uint16_t channel,
                     std::int64_t timestamp_ns,
                     const nlohmann::json& message);
    // Writes what is left, named texts about the file, indices and statistics.
    void commit(const std::string& name, const std::map<std::string, std::string>& texts);

private:
    using TimeAndOffset = std::pair<std::uint64_t, std::uint64_t>;
    struct TimeSpan {
        std::uint64_t begin_ns = 0;
        std::uint64_t end_ns = 0;
    };

    void put(std::string_view bytes);
    void put_record(std::uint8_t opcode, const Record& content);
    void flush_chunk();
    void put_summary(std::uint64_t metadata_at,
                     std::uint64_t metadata_bytes,
                     const std::string& name);

    base::AtomicFile file_;
    std::uint64_t size_bytes_ = 0;
    Crc32 section_crc_;  // of the bytes of the current section

    std::vector<Record> schemas_;  // contents of the records
    std::vector<Record> channels_;
    std::vector<std::uint64_t> num_messages_;  // by channel
    std::vector<Record> chunk_indices_;
    TimeSpan span_;

    Record chunk_;
    TimeSpan chunk_span_;
    std::map<std::uint16_t, std::vector<TimeAndOffset>> chunk_messages_;  // by channel
};

}  // namespace divemesh::io
