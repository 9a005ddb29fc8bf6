#include "worker/io/arithmetic_encoder.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/worker/io/arithmetic_decoder.hpp"
#include "worker/io/integer_encoder.hpp"

namespace divemesh::io {
namespace {

std::vector<std::uint32_t> skewed_symbols(std::uint32_t num_symbols, double skew, int num) {
    std::mt19937 random(num_symbols);
    std::geometric_distribution<std::uint32_t> distribution(skew);
    std::vector<std::uint32_t> symbols;
    for (int i = 0; i < num; ++i) symbols.push_back(distribution(random) % num_symbols);
    return symbols;
}

void expect_decodes(const std::vector<std::uint32_t>& symbols, std::uint32_t num_symbols) {
    ArithmeticEncoder encoder;
    AdaptiveSymbolModel model(num_symbols);
    for (const std::uint32_t symbol : symbols) encoder.encode(model, symbol);
    const std::string code = encoder.finish();

    ArithmeticDecoder decoder(code);
    DecodedSymbolModel decoded(num_symbols);
    for (std::size_t i = 0; i < symbols.size(); ++i)
        ASSERT_EQ(decoder.symbol(decoded), symbols[i]) << i << " of " << num_symbols;
    EXPECT_TRUE(decoder.is_at_end());
}

TEST(ArithmeticEncoderTest, ItsSymbolsAreDecodedFromAlphabetsOfAllSizes) {
    for (const std::uint32_t num_symbols : {2U, 3U, 33U, 128U, 256U, 2048U})
        for (const double skew : {0.9, 0.1, 0.005})
            expect_decodes(skewed_symbols(num_symbols, skew, 30'000), num_symbols);
}

// The last symbol lies at the upper end of the interval, where sums overflow: each such overflow
// must be carried into bytes that were given out, which may be a row of 0xFF.
TEST(ArithmeticEncoderTest, CarriesIntoBytesThatWereGivenOut) {
    expect_decodes(std::vector<std::uint32_t>(100'000, 255), 256);
    std::vector<std::uint32_t> symbols(100'000, 1);
    for (std::size_t i = 0; i < symbols.size(); i += 997) symbols[i] = 0;
    expect_decodes(symbols, 2);
}

TEST(ArithmeticEncoderTest, ACodeWithoutSymbolsIsTheFourBytesThatADecoderReadsAhead) {
    EXPECT_EQ(ArithmeticEncoder().finish().size(), 4U);
    expect_decodes({}, 2);
    expect_decodes({1}, 2);
}

TEST(ArithmeticEncoderTest, StartsAnewWhenItHasFinished) {
    ArithmeticEncoder encoder;
    for (int i = 0; i < 2; ++i) {
        for (std::uint32_t value = 0; value < 3'000; ++value) encoder.encode_raw(12, value);
        const std::string code = encoder.finish();

        ArithmeticDecoder decoder(code);
        for (std::uint32_t value = 0; value < 3'000; ++value) ASSERT_EQ(decoder.raw(12), value);
    }
}

TEST(ArithmeticEncoderTest, ItsBitsAreDecodedAmongRawOnes) {
    std::mt19937 random(1);
    std::bernoulli_distribution rare(0.003);
    std::vector<bool> bits;
    std::vector<std::uint32_t> raw;
    ArithmeticEncoder encoder;
    AdaptiveBitModel model;
    for (unsigned i = 0; i < 50'000; ++i) {
        const unsigned num_bits = 1 + i % 32;
        bits.push_back(rare(random));
        raw.push_back(static_cast<std::uint32_t>(random()) >> (32 - num_bits));
        encoder.encode_bit(model, bits.back());
        encoder.encode_raw(num_bits, raw.back());
    }
    const std::string code = encoder.finish();

    ArithmeticDecoder decoder(code);
    DecodedBitModel decoded;
    for (unsigned i = 0; i < bits.size(); ++i) {
        ASSERT_EQ(decoder.bit(decoded), bits[i]) << i;
        ASSERT_EQ(decoder.raw(1 + i % 32), raw[i]) << i;
    }
    EXPECT_TRUE(decoder.is_at_end());
}

// Shannon's bound for bits of which one in 100 is set: 0.0808 bit each.
TEST(ArithmeticEncoderTest, ItsCodeIsAsShortAsTheEntropy) {
    std::mt19937 random(2);
    std::bernoulli_distribution rare(0.01);
    constexpr int kNumBits = 1'000'000;
    ArithmeticEncoder encoder;
    AdaptiveBitModel model;
    for (int i = 0; i < kNumBits; ++i) encoder.encode_bit(model, rare(random));

    EXPECT_NEAR(8.0 * static_cast<double>(encoder.finish().size()) / kNumBits, 0.0808, 0.0025);
}

TEST(IntegerEncoderTest, ItsIntegersAreDecodedFromAnyPrediction) {
    using Limits = std::numeric_limits<std::int32_t>;
    std::vector<std::int32_t> values = {0, 1, -1, 2, Limits::max(), Limits::min(), -7, 0};
    std::mt19937 random(3);
    for (unsigned shift = 0; shift < 32; ++shift)
        for (int i = 0; i < 500; ++i)
            values.push_back(static_cast<std::int32_t>(random()) >> shift);
    ArithmeticEncoder encoder;
    IntegerEncoder integers(3);
    std::vector<unsigned> num_bits;
    for (std::size_t i = 0; i < values.size(); ++i) {
        integers.encode(encoder, values[(i + 5) % values.size()], values[i], i % 3);
        num_bits.push_back(integers.num_bits());
    }
    const std::string code = encoder.finish();

    ArithmeticDecoder decoder(code);
    IntegerDecoder decoded(3);
    for (std::size_t i = 0; i < values.size(); ++i) {
        ASSERT_EQ(decoded.decode(decoder, values[(i + 5) % values.size()], i % 3), values[i]) << i;
        ASSERT_EQ(decoded.k, num_bits[i]) << i;
    }
    EXPECT_TRUE(decoder.is_at_end());
}

// The corrector -2^31 alone has 32 bits.
TEST(IntegerEncoderTest, EncodesTheCorrectorOf32Bits) {
    ArithmeticEncoder encoder;
    IntegerEncoder integers(1);
    integers.encode(encoder, 5, std::numeric_limits<std::int32_t>::min() + 5, 0);
    EXPECT_EQ(integers.num_bits(), 32U);
    integers.encode(encoder, 0, 17, 0);
    const std::string code = encoder.finish();

    ArithmeticDecoder decoder(code);
    IntegerDecoder decoded(1);
    EXPECT_EQ(decoded.decode(decoder, 5, 0), std::numeric_limits<std::int32_t>::min() + 5);
    EXPECT_EQ(decoded.decode(decoder, 0, 0), 17);
}

}  // namespace
}  // namespace divemesh::io
