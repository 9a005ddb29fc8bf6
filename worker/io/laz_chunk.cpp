#include "worker/io/laz_chunk.hpp"

#include <algorithm>
#include <utility>

namespace divemesh::io {
namespace {

constexpr std::size_t kSingleReturn = 1;  // added to the contexts of such points

// Returns the context that a number of bits gives: even, and `max` at most.
std::size_t context_of(unsigned num_bits, unsigned max) {
    return kSingleReturn + std::min(num_bits & ~1U, max);
}

std::int32_t difference(std::int32_t value, std::int32_t last) {  // modulo 2^32
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(value) -
                                     static_cast<std::uint32_t>(last));
}

std::array<std::uint8_t, LasPoint::kExtra_bytes> extra_bytes(const LasPoint& point) {
    std::array<std::uint8_t, LasPoint::kExtra_bytes> bytes{};
    std::memcpy(bytes.data(), &point.sigma_m, sizeof point.sigma_m);
    std::memcpy(bytes.data() + sizeof point.sigma_m,
                &point.num_observations,
                sizeof point.num_observations);
    return bytes;
}

}  // namespace

void StreamingMedian::add(std::int32_t value) {
    const bool is_below = value < median();
    const bool is_above = value > median();
    sorted_[replaces_largest_ ? 4 : 0] = value;
    replaces_largest_ = replaces_largest_ ? is_below : !is_above;
    for (std::size_t i = 4; i > 0 && sorted_[i] < sorted_[i - 1]; --i)
        std::swap(sorted_[i], sorted_[i - 1]);
    for (std::size_t i = 0; i < 4 && sorted_[i] > sorted_[i + 1]; ++i)
        std::swap(sorted_[i], sorted_[i + 1]);
}

void PositionLayers::add(const LasPoint& point) {
    constexpr std::uint32_t kNoChange = 0;  // of returns, scanner, angle, source and time
    const auto [x, y, z_steps] = point.steps;
    xy.encode(changes_, kNoChange);
    encode_difference(dx_, dx_median_, difference(x, last_[0]), kSingleReturn);
    encode_difference(dy_, dy_median_, difference(y, last_[1]), context_of(dx_.num_bits(), 20));
    z_encoder_.encode(z, last_[2], z_steps, context_of((dx_.num_bits() + dy_.num_bits()) / 2, 18));
    last_ = point.steps;
}

void PositionLayers::encode_difference(IntegerEncoder& encoder,
                                       StreamingMedian& median,
                                       std::int32_t difference,
                                       std::size_t context) {
    encoder.encode(xy, median.median(), difference, context);
    median.add(difference);
}

void ColorLayer::add(const LasPoint& point) {
    const auto [red, green, blue] = point.color;
    const bool is_grey = red == green && red == blue;
    std::uint32_t changes = is_grey ? 0 : 1 << 6;
    for (std::size_t i = 0; i < 3; ++i)
        if (point.color[i] != last_[i]) changes |= 2U << 2 * i;  // the upper byte of channel i
    encoder.encode(changes_, changes);

    // What red changed by is the prediction for green, and the mean of both that for blue.
    const auto encode = [&](std::size_t i, int predicted_change) {
        if (point.color[i] == last_[i]) return;
        const int prediction = std::clamp(last_[i] + predicted_change, 0, 255);
        encoder.encode(differences_[i], static_cast<std::uint8_t>(point.color[i] - prediction));
    };
    const int red_change = red - last_[0];
    encode(0, 0);
    if (!is_grey) {
        encode(1, red_change);
        encode(2, (red_change + green - last_[1]) / 2);
    }
    has_changed = has_changed || point.color != last_;
    last_ = point.color;
}

void ByteLayer::add(std::uint8_t byte) {
    encoder.encode(differences_, static_cast<std::uint8_t>(byte - last_));
    has_changed = has_changed || byte != last_;
    last_ = byte;
}

LazChunk::Layers::Layers(const LasPoint& first) : position(first), color(first) {
    for (const std::uint8_t byte : extra_bytes(first)) extra.emplace_back(byte);
}

void LazChunk::Layers::add(const LasPoint& point) {
    position.add(point);
    color.add(point);
    const auto bytes = extra_bytes(point);
    for (std::size_t i = 0; i < bytes.size(); ++i) extra[i].add(bytes[i]);
}

void LazChunk::add(const LasPoint& point) {
    if (num_points_++ > 0) {
        layers_->add(point);
        return;
    }
    first_ = point;
    layers_.emplace(point);
}

std::string LazChunk::finish() {
    constexpr std::size_t kConstantLayers = 7;  // class, flags, intensity ... GPS time
    std::vector<std::string> layers = {layers_->position.xy.finish(), layers_->position.z.finish()};
    layers.resize(layers.size() + kConstantLayers);
    const auto append = [&](auto& layer) {
        layers.push_back(layer.has_changed ? layer.encoder.finish() : "");
    };
    append(layers_->color);
    for (ByteLayer& layer : layers_->extra) append(layer);

    Record record;
    put_point(record, first_);
    record.put(std::exchange(num_points_, 0));
    for (const std::string& layer : layers) record.put(static_cast<std::uint32_t>(layer.size()));
    for (const std::string& layer : layers) record.put_field(layer, layer.size());
    return std::string(record.bytes());
}

}  // namespace divemesh::io
