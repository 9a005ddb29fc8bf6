#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace divemesh::recording {

// Little-endian bytes, value by value.
class TestBytes {
public:
    template <typename Value>
    TestBytes& put(Value value) {
        const auto* first = reinterpret_cast<const char*>(&value);
        bytes.append(first, sizeof value);
        return *this;
    }
    template <typename Size>
    TestBytes& put_sized(std::string_view text) {
        put(static_cast<Size>(text.size()));
        bytes.append(text);
        return *this;
    }
    std::string bytes;
};

// Compresses by the libraries of the formats: "", "none", "lz4", "zstd", "bz2".
std::string packed(const std::string& codec, const std::string& bytes);

// Writes a ROS 1 bag as wiki.ros.org/Bags/Format/2.0 describes it, with chunks but without indices,
// as a bag is before it is closed.
class BagWriter {
public:
    explicit BagWriter(std::string codec = "none") : codec_(std::move(codec)) {}

    void add_connection(std::uint32_t number, const std::string& topic, const std::string& type);
    void add_message(std::uint32_t connection, std::int64_t time_ns, const std::string& bytes);
    // Ends the chunk; `claimed_bytes` is what it says of its size, by default the truth.
    void end_chunk(std::int64_t claimed_bytes = -1);
    std::string finished();

private:
    static std::string header(const std::map<std::string, std::string>& fields);
    static std::string record(const std::string& header, const std::string& data);

    std::string codec_;
    std::string chunk_;
    std::string file_ = "#ROSBAG V2.0\n";
    bool has_bag_header_ = false;
};

// Writes MCAP as mcap.dev/spec describes it. Without a codec messages lie outside of chunks.
class McapBytes {
public:
    explicit McapBytes(std::string codec) : codec_(std::move(codec)) {}

    void add_channel(std::uint16_t number,
                     const std::string& topic,
                     const std::string& type,
                     const std::string& encoding);
    void add_message(std::uint16_t channel, std::int64_t time_ns, const std::string& bytes);
    // Ends the chunk; the size and checksum that it states can be false.
    void end_chunk(std::int64_t claimed_bytes = -1, std::uint32_t crc_change = 0);
    std::string finished();

    static std::string record(std::uint8_t opcode, const std::string& content);

private:
    std::string codec_;  // "outside": no chunks
    std::string chunk_;
    std::string file_ = "\x89MCAP0\r\n" + record(0x01, std::string(8, '\0'));
};

}  // namespace divemesh::recording
