#include "tests/worker/io/laz_decoder.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>

#include "tests/worker/io/arithmetic_decoder.hpp"

namespace divemesh::io {
namespace {

constexpr std::size_t kRecord_bytes = 44;
constexpr std::size_t kNumLayers = 9 + 1 + 8;

void require(bool holds, const char* what) {
    if (!holds) throw std::runtime_error(what);
}

template <typename Value>
Value at(std::string_view bytes, std::size_t offset) {
    require(offset + sizeof(Value) <= bytes.size(), "the file is too short");
    Value value{};
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

// Five values, of which the largest or the smallest is replaced by a new one; which it is changes
// when a value does not lie on that side of the median.
class Median5 {
public:
    std::int32_t get() const { return values_[2]; }
    void add(std::int32_t value) {
        const std::int32_t before = get();
        values_.erase(at_top_ ? values_.end() - 1 : values_.begin());
        values_.insert(std::upper_bound(values_.begin(), values_.end(), value), value);
        if (at_top_ ? value >= before : value <= before) at_top_ = !at_top_;
    }

private:
    std::vector<std::int32_t> values_ = std::vector<std::int32_t>(5, 0);
    bool at_top_ = true;
};

class ChunkDecoder {
public:
    explicit ChunkDecoder(std::string_view chunk) : record_(chunk.substr(0, kRecord_bytes)) {
        num_points = at<std::uint32_t>(chunk, kRecord_bytes);
        std::size_t size_at = kRecord_bytes + 4;
        std::size_t layer_at = size_at + 4 * kNumLayers;
        for (std::size_t i = 0; i < kNumLayers; ++i, size_at += 4) {
            const auto size = at<std::uint32_t>(chunk, size_at);
            require(layer_at + size <= chunk.size(), "a layer is cut");
            layers_.push_back(chunk.substr(layer_at, size));
            layer_at += size;
        }
        require(layer_at == chunk.size(), "bytes after the layers");
        for (std::size_t i = 2; i < 9; ++i) require(layers_[i].empty(), "another layer");
        for (const std::string_view layer : layers_)
            decoders_.emplace_back(layer.empty() ? std::string_view("\0\0\0\0", 4) : layer);
    }

    const std::string& first() const { return record_; }
    const std::string& next() {
        next_position();
        if (!layers_[9].empty()) next_color();
        for (std::size_t i = 0; i < 8; ++i)
            if (!layers_[10 + i].empty())
                byte(36 + i) =
                    static_cast<unsigned char>(byte(36 + i) + decoders_[10 + i].symbol(extra_[i]));
        return record_;
    }
    void require_end() const {
        for (std::size_t i = 0; i < kNumLayers; ++i)
            require(layers_[i].empty() || decoders_[i].is_at_end(), "bytes after a layer's code");
    }
    std::uint32_t num_points;

private:
    unsigned char& byte(std::size_t i) { return reinterpret_cast<unsigned char&>(record_[i]); }
    void add_to_coordinate(std::size_t i, std::int32_t difference) {
        const auto sum = at<std::uint32_t>(record_, 4 * i) + static_cast<std::uint32_t>(difference);
        std::memcpy(record_.data() + 4 * i, &sum, sizeof sum);
    }
    void next_position() {
        require(decoders_[0].symbol(changed_) == 0, "a changed return, scanner, angle or time");
        const std::int32_t dx = dx_.decode(decoders_[0], dx_median_.get(), 1);
        dx_median_.add(dx);
        add_to_coordinate(0, dx);
        const std::uint32_t dy_context = dx_.k < 20 ? dx_.k & ~1U : 20;
        const std::int32_t dy = dy_.decode(decoders_[0], dy_median_.get(), 1 + dy_context);
        dy_median_.add(dy);
        add_to_coordinate(1, dy);
        const std::uint32_t k = (dx_.k + dy_.k) / 2;
        const auto z = at<std::int32_t>(record_, 8);
        const std::int32_t new_z = z_.decode(decoders_[1], z, 1 + (k < 18 ? k & ~1U : 18));
        std::memcpy(record_.data() + 8, &new_z, sizeof new_z);
    }
    // Decodes the byte at `i` whose prediction is the last value and a change.
    int next_color_byte(std::size_t i, int change, std::size_t model) {
        const int last = byte(i);
        const int prediction = std::clamp(last + change, 0, 255);
        byte(i) = static_cast<unsigned char>(prediction + decoders_[9].symbol(color_[model]));
        return byte(i) - last;
    }
    void next_color() {
        const std::uint32_t changes = decoders_[9].symbol(color_changes_);
        std::array<int, 2> red{};
        for (std::size_t half = 0; half < 2; ++half)
            if (changes & (1U << half)) red[half] = next_color_byte(30 + half, 0, half);
        if ((changes & 64) == 0) {
            for (const std::size_t channel : {32, 34})
                for (std::size_t half = 0; half < 2; ++half) byte(channel + half) = byte(30 + half);
            return;
        }
        for (std::size_t half = 0; half < 2; ++half) {
            int green = 0;
            if (changes & (4U << half)) green = next_color_byte(32 + half, red[half], 2 + half);
            if (changes & (16U << half))
                next_color_byte(34 + half, (red[half] + green) / 2, 4 + half);
        }
    }

    std::string record_;
    std::vector<std::string_view> layers_;
    std::vector<ArithmeticDecoder> decoders_;
    DecodedSymbolModel changed_{128};
    DecodedSymbolModel color_changes_{128};
    std::vector<DecodedSymbolModel> color_ = std::vector(6, DecodedSymbolModel(256));
    std::vector<DecodedSymbolModel> extra_ = std::vector(8, DecodedSymbolModel(256));
    IntegerDecoder dx_{2};
    IntegerDecoder dy_{22};
    IntegerDecoder z_{20};
    Median5 dx_median_;
    Median5 dy_median_;
};

std::vector<std::uint32_t> chunk_sizes(std::string_view table) {
    require(at<std::uint32_t>(table, 0) == 0, "the version of the chunk table");
    const auto num_chunks = at<std::uint32_t>(table, 4);
    std::vector<std::uint32_t> sizes;
    if (num_chunks == 0) {
        require(table.size() == 8, "bytes after an empty table");
        return sizes;
    }
    ArithmeticDecoder decoder(table.substr(8));
    IntegerDecoder integers(2);
    std::int32_t size = 0;
    for (std::uint32_t i = 0; i < num_chunks; ++i) {
        size = integers.decode(decoder, size, 1);
        sizes.push_back(static_cast<std::uint32_t>(size));
    }
    require(decoder.is_at_end(), "bytes after the chunk table");
    return sizes;
}

}  // namespace

std::vector<std::string> laz_records(const std::string& file) {
    const std::string_view bytes = file;
    const std::size_t points_at = at<std::uint32_t>(bytes, 96);
    const auto table_at = at<std::uint64_t>(bytes, points_at);
    require(table_at <= bytes.size(), "the chunk table is outside of the file");
    std::vector<std::string> records;
    std::size_t chunk_at = points_at + 8;
    for (const std::uint32_t size : chunk_sizes(bytes.substr(table_at))) {
        require(chunk_at + size <= table_at, "a chunk reaches into the table");
        ChunkDecoder chunk(bytes.substr(chunk_at, size));
        records.push_back(chunk.first());
        for (std::uint32_t i = 1; i < chunk.num_points; ++i) records.push_back(chunk.next());
        chunk.require_end();
        chunk_at += size;
    }
    require(chunk_at == table_at, "bytes between the last chunk and the table");
    return records;
}

}  // namespace divemesh::io
