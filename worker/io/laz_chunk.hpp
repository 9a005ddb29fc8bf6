#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "worker/io/integer_encoder.hpp"
#include "worker/io/las_point.hpp"

namespace divemesh::io {

// Returns the median of five values in a stream: a new one replaces the largest or the smallest,
// in turn as the values rise or fall (Isenburg, "LASzip", 2013, 4.2). All are 0 at first.
class StreamingMedian {
public:
    std::int32_t median() const { return sorted_[2]; }
    void add(std::int32_t value);

private:
    std::array<std::int32_t, 5> sorted_{};
    bool replaces_largest_ = true;
};

// The coordinates of the points after the first: two layers, of x and y and of z. Each point of
// ours is the only return of its pulse, of one scanner and one time, which fixes most contexts.
class PositionLayers {
public:
    explicit PositionLayers(const LasPoint& first) : last_(first.steps) {}
    void add(const LasPoint& point);

    ArithmeticEncoder xy;
    ArithmeticEncoder z;

private:
    void encode_difference(IntegerEncoder& encoder,
                           StreamingMedian& median,
                           std::int32_t difference,
                           std::size_t context);

    std::array<std::int32_t, 3> last_;
    AdaptiveSymbolModel changes_{128};
    IntegerEncoder dx_{2};
    IntegerEncoder dy_{22};
    IntegerEncoder z_encoder_{20};
    StreamingMedian dx_median_;
    StreamingMedian dy_median_;
};

// The colours of the points after the first, whose lower bytes are all 0.
class ColorLayer {
public:
    explicit ColorLayer(const LasPoint& first) : last_(first.color) {}
    void add(const LasPoint& point);

    ArithmeticEncoder encoder;
    bool has_changed = false;

private:
    types::Color last_;
    AdaptiveSymbolModel changes_{128};
    std::array<AdaptiveSymbolModel, 3> differences_{
        AdaptiveSymbolModel(256), AdaptiveSymbolModel(256), AdaptiveSymbolModel(256)};
};

// One extra byte of the points after the first.
class ByteLayer {
public:
    explicit ByteLayer(std::uint8_t first) : last_(first) {}
    void add(std::uint8_t byte);

    ArithmeticEncoder encoder;
    bool has_changed = false;

private:
    std::uint8_t last_;
    AdaptiveSymbolModel differences_{256};
};

// A chunk of a LAZ file, which a reader can decode alone: the first point as it is, the number of
// points, the sizes of all layers and the layers (LASzip "native extension" for LAS 1.4, items
// POINT14, RGB14 and BYTE14 of version 3). A layer whose values never change has no bytes.
class LazChunk {
public:
    static constexpr std::uint32_t kMaxPoints = 50'000;

    void add(const LasPoint& point);
    std::uint32_t num_points() const { return num_points_; }
    // Returns the bytes of a chunk with at least one point.
    std::string finish();

private:
    struct Layers {
        explicit Layers(const LasPoint& first);
        void add(const LasPoint& point);

        PositionLayers position;
        ColorLayer color;
        std::vector<ByteLayer> extra;
    };

    LasPoint first_;
    std::optional<Layers> layers_;
    std::uint32_t num_points_ = 0;
};

}  // namespace divemesh::io
