#include "tests/worker/recording/bag_writer.hpp"

#include <bzlib.h>
#include <libdeflate.h>
#include <lz4frame.h>
#include <stdexcept>
#include <zstd.h>

namespace divemesh::recording {

std::string packed(const std::string& codec, const std::string& bytes) {
    if (codec.empty() || codec == "none") return bytes;
    std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr) +
                        ZSTD_compressBound(bytes.size()) + 2 * bytes.size() + 600,
                    '\0');
    std::size_t size = 0;
    if (codec == "lz4") {
        size = LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
    } else if (codec == "zstd") {
        size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3);
    } else if (codec == "bz2") {
        auto num_bytes = static_cast<unsigned int>(out.size());
        BZ2_bzBuffToBuffCompress(out.data(),
                                 &num_bytes,
                                 const_cast<char*>(bytes.data()),
                                 static_cast<unsigned int>(bytes.size()),
                                 9,
                                 0,
                                 0);
        size = num_bytes;
    } else {
        throw std::invalid_argument(codec);
    }
    out.resize(size);
    return out;
}

std::string BagWriter::header(const std::map<std::string, std::string>& fields) {
    TestBytes header;
    for (const auto& [name, value] : fields) header.put_sized<std::uint32_t>(name + "=" + value);
    return header.bytes;
}

std::string BagWriter::record(const std::string& header, const std::string& data) {
    return TestBytes().put_sized<std::uint32_t>(header).put_sized<std::uint32_t>(data).bytes;
}

void BagWriter::add_connection(std::uint32_t number,
                               const std::string& topic,
                               const std::string& type) {
    const std::string conn = TestBytes().put(number).bytes;
    chunk_ += record(header({{"op", "\x07"}, {"conn", conn}, {"topic", topic}}),
                     header({{"topic", topic},
                             {"type", type},
                             {"md5sum", std::string(32, '0')},
                             {"message_definition", "# not needed"}}));
}

void BagWriter::add_message(std::uint32_t connection,
                            std::int64_t time_ns,
                            const std::string& bytes) {
    TestBytes time;
    time.put(static_cast<std::uint32_t>(time_ns / 1'000'000'000));
    time.put(static_cast<std::uint32_t>(time_ns % 1'000'000'000));
    const std::string conn = TestBytes().put(connection).bytes;
    chunk_ += record(header({{"op", "\x02"}, {"conn", conn}, {"time", time.bytes}}), bytes);
}

void BagWriter::end_chunk(std::int64_t claimed_bytes) {
    if (!has_bag_header_) {
        const std::string number8 = TestBytes().put(std::uint64_t{0}).bytes;
        const std::string number4 = TestBytes().put(std::uint32_t{0}).bytes;
        file_ += record(header({{"op", "\x03"},
                                {"index_pos", number8},
                                {"conn_count", number4},
                                {"chunk_count", number4}}),
                        std::string(64, ' '));
        has_bag_header_ = true;
    }
    const auto size =
        static_cast<std::uint32_t>(claimed_bytes < 0 ? std::ssize(chunk_) : claimed_bytes);
    file_ += record(
        header({{"op", "\x05"}, {"compression", codec_}, {"size", TestBytes().put(size).bytes}}),
        packed(codec_, chunk_));
    chunk_.clear();
}

std::string BagWriter::finished() {
    if (!chunk_.empty()) end_chunk();
    return file_;
}

std::string McapBytes::record(std::uint8_t opcode, const std::string& content) {
    return TestBytes().put(opcode).put_sized<std::uint64_t>(content).bytes;
}

void McapBytes::add_channel(std::uint16_t number,
                            const std::string& topic,
                            const std::string& type,
                            const std::string& encoding) {
    TestBytes schema;
    schema.put(static_cast<std::uint16_t>(number + 1));
    schema.put_sized<std::uint32_t>(type).put_sized<std::uint32_t>("ros2msg");
    schema.put_sized<std::uint32_t>("# not needed");
    TestBytes channel;
    channel.put(number).put(static_cast<std::uint16_t>(number + 1));
    channel.put_sized<std::uint32_t>(topic).put_sized<std::uint32_t>(encoding);
    channel.put(std::uint32_t{0});
    chunk_ += record(0x03, schema.bytes) + record(0x04, channel.bytes);
}

void McapBytes::add_message(std::uint16_t channel, std::int64_t time_ns, const std::string& bytes) {
    TestBytes message;
    message.put(channel).put(std::uint32_t{0}).put(time_ns).put(time_ns);
    chunk_ += record(0x05, message.bytes + bytes);
}

void McapBytes::end_chunk(std::int64_t claimed_bytes, std::uint32_t crc_change) {
    if (codec_ == "outside") {
        file_ += chunk_;
    } else {
        TestBytes chunk;
        chunk.put(std::int64_t{0}).put(std::int64_t{0});
        chunk.put(claimed_bytes < 0 ? std::int64_t{std::ssize(chunk_)} : claimed_bytes);
        chunk.put(libdeflate_crc32(0, chunk_.data(), chunk_.size()) + crc_change);
        chunk.put_sized<std::uint32_t>(codec_);
        chunk.put_sized<std::uint64_t>(packed(codec_, chunk_));
        file_ += record(0x06, chunk.bytes);
    }
    chunk_.clear();
}

std::string McapBytes::finished() {
    if (!chunk_.empty()) end_chunk();
    return file_ + record(0x0f, std::string(4, '\0')) + record(0x02, std::string(20, '\0')) +
           "\x89MCAP0\r\n";
}

}  // namespace divemesh::recording
