#include "worker/video/gpmf.hpp"

#include <algorithm>
#include <bit>

namespace divemesh::video {
namespace {

constexpr int kMaxDepth = 8;  // DEVC, STRM and what they hold
constexpr std::size_t kHead_bytes = 8;
constexpr std::size_t kAxes = 3;
constexpr std::string_view kDefaultAxes = "ZXY";  // of the HERO5, which states none

std::uint64_t big_endian(std::string_view bytes) {
    std::uint64_t value = 0;
    for (const char byte : bytes) value = value << 8U | static_cast<unsigned char>(byte);
    return value;
}

// A key with its value.
struct Klv {
    std::string_view key;
    char type = '\0';  // '\0': the value is a list of such keys
    std::size_t sample_bytes = 0;
    std::size_t num_samples = 0;
    std::string_view value;
};

// Takes keys from the front of a list.
class KlvList {
public:
    explicit KlvList(std::string_view bytes) : bytes_(bytes) {}

    std::optional<Klv> next() {
        if (bytes_.size() < kHead_bytes) {
            is_damaged_ = is_damaged_ || !bytes_.empty();
            return std::nullopt;
        }
        Klv klv{bytes_.substr(0, 4),
                bytes_[4],
                static_cast<unsigned char>(bytes_[5]),
                big_endian(bytes_.substr(6, 2)),
                {}};
        const std::size_t size = klv.sample_bytes * klv.num_samples;  // below 2^24
        const std::size_t filled = (size + 3) / 4 * 4;
        if (klv.key == std::string_view("\0\0\0\0", 4))
            return std::nullopt;  // filled up to the end
        if (size > bytes_.size() - kHead_bytes) {
            is_damaged_ = true;
            return std::nullopt;
        }
        klv.value = bytes_.substr(kHead_bytes, size);
        bytes_.remove_prefix(std::min(kHead_bytes + filled, bytes_.size()));
        return klv;
    }

    bool is_damaged() const { return is_damaged_; }

private:
    std::string_view bytes_;
    bool is_damaged_ = false;
};

// clang-format off
std::size_t size_of_type(char type) {
    switch (type) {
        case 'b': case 'B': case 'c': return 1;
        case 's': case 'S': return 2;
        case 'l': case 'L': case 'f': case 'q': return 4;
        case 'd': case 'j': case 'J': case 'Q': return 8;
        default: return 0;
    }
}
// clang-format on

// Returns a number of a type for which size_of_type() is not 0.
double number_of(char type, std::string_view bytes) {
    const std::uint64_t bits = big_endian(bytes);
    switch (type) {
        case 'b': return static_cast<std::int8_t>(bits);
        case 's': return static_cast<std::int16_t>(bits);
        case 'l': return static_cast<std::int32_t>(bits);
        case 'j': return static_cast<double>(static_cast<std::int64_t>(bits));
        case 'q': return static_cast<std::int32_t>(bits) / 65536.0;
        case 'Q': return static_cast<double>(static_cast<std::int64_t>(bits)) / 4294967296.0;
        case 'f': return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
        case 'd': return std::bit_cast<double>(bits);
        default: return static_cast<double>(bits);
    }
}

// Returns all numbers of a value, whatever its samples; none for a type that is no number.
std::vector<double> numbers_of(const Klv& klv) {
    const std::size_t size = size_of_type(klv.type);
    std::vector<double> numbers;
    if (size == 0 || klv.sample_bytes % size != 0) return numbers;
    numbers.reserve(klv.value.size() / size);
    for (std::size_t at = 0; at + size <= klv.value.size(); at += size)
        numbers.push_back(number_of(klv.type, klv.value.substr(at, size)));
    return numbers;
}

// What a stream states about the samples that follow.
struct StreamState {
    std::vector<double> scale = {1.0};  // SCAL: divisors, one or one an axis
    std::string axes{kDefaultAxes};     // ORIN: of each number; a small letter turns its sign
    std::optional<std::int64_t> num_until_here;
};

// Returns whether each of X, Y and Z is there once.
bool are_axes(std::string_view axes) {
    bool is_there[kAxes] = {};
    for (const char axis : axes) {
        const int place = (axis & ~0x20) - 'X';
        if (place < 0 || place >= static_cast<int>(kAxes) || is_there[place]) return false;
        is_there[place] = true;
    }
    return axes.size() == kAxes;
}

Eigen::Vector3d sample_of(const double* numbers, const StreamState& state) {
    Eigen::Vector3d sample = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < kAxes; ++i) {
        const char axis = state.axes[i];
        const double divisor = state.scale[state.scale.size() == kAxes ? i : 0];
        const bool is_turned = (axis & 0x20) != 0;
        sample[(axis & ~0x20) - 'X'] = (is_turned ? -numbers[i] : numbers[i]) / divisor;
    }
    return sample;
}

// Appends the samples of a sensor. One that is no number, or infinite by its scale, stays out with
// all of its payload, as the times of the others follow from their number.
void add_samples(const Klv& klv, const StreamState& state, GpmfSamples& samples) {
    const auto numbers = numbers_of(klv);
    if (klv.sample_bytes != kAxes * size_of_type(klv.type) || !are_axes(state.axes)) return;
    if (state.scale.size() != 1 && state.scale.size() != kAxes) return;
    std::vector<Eigen::Vector3d> values;
    values.reserve(numbers.size() / kAxes);
    for (std::size_t at = 0; at + kAxes <= numbers.size(); at += kAxes) {
        values.push_back(sample_of(&numbers[at], state));
        if (!values.back().allFinite()) return;
    }
    if (!samples.values.empty()) return;  // a second sensor, of another device
    samples.values = std::move(values);
    samples.num_until_here = state.num_until_here;
}

void read_list(std::string_view bytes, int depth, GpmfMotion& motion) {
    KlvList list(bytes);
    StreamState state;
    while (const auto klv = list.next()) {
        if (klv->type == '\0') {
            if (depth < kMaxDepth) read_list(klv->value, depth + 1, motion);
        } else if (klv->key == "SCAL") {
            state.scale = numbers_of(*klv);
        } else if (klv->key == "ORIN") {
            state.axes = klv->value.substr(0, klv->value.find('\0'));
        } else if (klv->key == "TSMP") {
            if (klv->type == 'L' && klv->value.size() == 4)
                state.num_until_here = static_cast<std::int64_t>(big_endian(klv->value));
        } else if (klv->key == "GYRO") {
            add_samples(*klv, state, motion.gyroscope);
        } else if (klv->key == "ACCL") {
            add_samples(*klv, state, motion.accelerometer);
        }
    }
    motion.is_damaged = motion.is_damaged || list.is_damaged();
}

}  // namespace

GpmfMotion parse_gpmf(std::string_view bytes) {
    GpmfMotion motion;
    read_list(bytes, 0, motion);
    return motion;
}

}  // namespace divemesh::video
