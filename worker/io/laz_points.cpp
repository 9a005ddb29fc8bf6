#include "worker/io/laz_points.hpp"

#include <numeric>

namespace divemesh::io {
namespace {

struct Item {
    std::uint16_t type;
    std::uint16_t size_bytes;
};

constexpr Item kItems[] = {{10, LasPoint::kBase_bytes},    // POINT14
                           {11, LasPoint::kColor_bytes},   // RGB14
                           {14, LasPoint::kExtra_bytes}};  // BYTE14

// Returns the table of the chunks' sizes, each predicted by the one before it.
std::string chunk_table(const std::vector<std::uint32_t>& sizes_bytes) {
    constexpr std::size_t kSizeContext = 1;  // 0 is that of numbers of points, if they vary
    Record table;
    table.put(std::uint32_t{0});  // version
    table.put(static_cast<std::uint32_t>(sizes_bytes.size()));
    if (sizes_bytes.empty()) return std::string(table.bytes());
    ArithmeticEncoder encoder;
    IntegerEncoder sizes(2);
    std::int32_t last = 0;
    for (const std::uint32_t size_bytes : sizes_bytes) {
        const auto size = static_cast<std::int32_t>(size_bytes);
        sizes.encode(encoder, last, size, kSizeContext);
        last = size;
    }
    return std::string(table.bytes()) + encoder.finish();
}

}  // namespace

std::string laszip_record() {
    constexpr std::uint16_t kLayeredChunks = 3;
    constexpr std::uint16_t kArithmeticCoder = 0;
    constexpr std::uint16_t kItemVersion = 3;
    Record record;
    record.put(kLayeredChunks);
    record.put(kArithmeticCoder);
    record.put(std::uint8_t{3});  // the version of LASzip whose format this is: 3.4.3
    record.put(std::uint8_t{4});
    record.put(std::uint16_t{3});
    record.put(std::uint32_t{0});  // options
    record.put(LazChunk::kMaxPoints);
    record.put(std::int64_t{-1});  // no special extended records: their number
    record.put(std::int64_t{-1});  // and offset
    record.put(static_cast<std::uint16_t>(std::size(kItems)));
    for (const Item& item : kItems) {
        record.put(item.type);
        record.put(item.size_bytes);
        record.put(kItemVersion);
    }
    return std::string(record.bytes());
}

LazPoints::LazPoints(base::AtomicFile& file, std::uint64_t offset_bytes)
    : file_(file), offset_bytes_(offset_bytes) {
    Record table_offset;
    table_offset.put(std::uint64_t{0});  // finish() knows it
    table_offset.flush_to(file_);
}

void LazPoints::add(const LasPoint& point) {
    chunk_.add(point);
    if (chunk_.num_points() == LazChunk::kMaxPoints) write_chunk();
}

void LazPoints::finish() {
    if (chunk_.num_points() > 0) write_chunk();
    file_.write(chunk_table(chunk_sizes_bytes_));
    Record table_offset;
    table_offset.put(std::accumulate(chunk_sizes_bytes_.begin(),
                                     chunk_sizes_bytes_.end(),
                                     offset_bytes_ + sizeof(std::uint64_t)));
    file_.overwrite(offset_bytes_, table_offset.bytes());
}

void LazPoints::write_chunk() {
    const std::string bytes = chunk_.finish();
    chunk_sizes_bytes_.push_back(static_cast<std::uint32_t>(bytes.size()));
    file_.write(bytes);
}

}  // namespace divemesh::io
