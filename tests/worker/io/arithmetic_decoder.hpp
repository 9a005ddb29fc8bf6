#pragma once

#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace divemesh::io {

// The decoder of LASzip's arithmetic code, written from its definition: Said, "Introduction to
// Arithmetic Coding" (HPL-2004-76), 2.2 and 3.3, with the constants of Isenburg's coder.

struct DecodedBitModel {
    std::uint32_t zero = 1 << 12;  // of 2^13
    std::uint32_t zeros = 1;
    std::uint32_t bits = 2;
    std::uint32_t cycle = 4;
    std::uint32_t wait = 4;
};

struct DecodedSymbolModel {
    explicit DecodedSymbolModel(std::uint32_t num_symbols)
        : counts(num_symbols, 1), begin(num_symbols + 1) {
        cycle = num_symbols;
        total = 0;
        renew();
        cycle = wait = (num_symbols + 6) >> 1;
    }
    void renew() {
        total += cycle;
        if (total > 32768) {
            total = 0;
            for (auto& count : counts) {
                count = (count + 1) >> 1;
                total += count;
            }
        }
        const std::uint64_t scale = 0x8000'0000ULL / total;
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < counts.size(); ++i) {
            begin[i] = static_cast<std::uint32_t>((scale * sum) >> 16);
            sum += counts[i];
        }
        cycle = (5 * cycle) >> 2;
        const auto max = static_cast<std::uint32_t>((counts.size() + 6) << 3);
        if (cycle > max) cycle = max;
        wait = cycle;
    }
    std::vector<std::uint32_t> counts;
    std::vector<std::uint32_t> begin;  // of 2^15
    std::uint32_t total;
    std::uint32_t cycle;
    std::uint32_t wait;
};

class ArithmeticDecoder {
public:
    explicit ArithmeticDecoder(std::string_view bytes) : bytes_(bytes) {
        for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next();
    }

    bool bit(DecodedBitModel& model) {
        const std::uint32_t middle = (length_ >> 13) * model.zero;
        const bool result = value_ >= middle;
        if (result)
            take(middle, length_ - middle);
        else
            take(0, middle);
        model.zeros += result ? 0 : 1;
        if (--model.wait == 0) {
            model.bits += model.cycle;
            if (model.bits > 8192) {
                model.bits = (model.bits + 1) >> 1;
                model.zeros = (model.zeros + 1) >> 1;
                if (model.zeros == model.bits) ++model.bits;
            }
            model.zero =
                static_cast<std::uint32_t>((model.zeros * (0x8000'0000ULL / model.bits)) >> 18);
            model.cycle = model.cycle * 5 / 4 > 64 ? 64 : model.cycle * 5 / 4;
            model.wait = model.cycle;
        }
        return result;
    }
    std::uint32_t symbol(DecodedSymbolModel& model) {
        const std::uint32_t unit = length_ >> 15;
        const auto num_symbols = static_cast<std::uint32_t>(model.counts.size());
        std::uint32_t symbol = num_symbols - 1;
        while (unit * model.begin[symbol] > value_) --symbol;
        const std::uint32_t low = unit * model.begin[symbol];
        const std::uint32_t high =
            symbol + 1 == num_symbols ? length_ : unit * model.begin[symbol + 1];
        take(low, high - low);
        ++model.counts[symbol];
        if (--model.wait == 0) model.renew();
        return symbol;
    }
    std::uint32_t raw(unsigned num_bits) {
        if (num_bits > 19) {
            const std::uint32_t lower = raw(16);
            return raw(num_bits - 16) << 16 | lower;
        }
        const std::uint32_t unit = length_ >> num_bits;
        const std::uint32_t result = value_ / unit;
        take(result * unit, unit);
        return result;
    }
    // Returns whether it has read all bytes and no more.
    bool is_at_end() const { return position_ == bytes_.size(); }

private:
    std::uint32_t next() {
        if (position_ == bytes_.size()) throw std::runtime_error("read past the code's end");
        return static_cast<unsigned char>(bytes_[position_++]);
    }
    void take(std::uint32_t low, std::uint32_t length) {
        value_ -= low;
        length_ = length;
        if (value_ >= length_) throw std::runtime_error("a value outside of its interval");
        while (length_ < 1 << 24) {
            value_ = value_ << 8 | next();
            length_ <<= 8;
        }
    }

    std::string_view bytes_;
    std::size_t position_ = 0;
    std::uint32_t value_ = 0;
    std::uint32_t length_ = 0xFFFF'FFFF;
};

// The decoder of integers (Isenburg 2013, 4.1), with all 32 bits.
class IntegerDecoder {
public:
    explicit IntegerDecoder(std::size_t num_contexts)
        : bits_(num_contexts, DecodedSymbolModel(33)) {
        for (int bits = 1; bits <= 32; ++bits) place_.emplace_back(bits < 8 ? 1 << bits : 256);
    }
    std::int32_t decode(ArithmeticDecoder& decoder, std::int32_t prediction, std::size_t context) {
        k = decoder.symbol(bits_[context]);
        return static_cast<std::int32_t>(
            static_cast<std::uint32_t>(prediction + corrector(decoder)));
    }
    std::uint32_t k = 0;

private:
    std::int64_t corrector(ArithmeticDecoder& decoder) {
        if (k == 0) return decoder.bit(unit_) ? 1 : 0;
        if (k == 32) return INT32_MIN;
        std::int64_t place = decoder.symbol(place_[k - 1]);
        if (k > 8) place = place << (k - 8) | decoder.raw(k - 8);
        const std::int64_t half = std::int64_t{1} << (k - 1);
        return place >= half ? place + 1 : place - (2 * half - 1);
    }

    std::vector<DecodedSymbolModel> bits_;
    std::vector<DecodedSymbolModel> place_;
    DecodedBitModel unit_;
};

}  // namespace divemesh::io
