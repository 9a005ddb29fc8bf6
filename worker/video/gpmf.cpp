#include "worker/video/gpmf.hpp"

#include "worker/video/gpmf_klv.hpp"

namespace divemesh::video {
namespace {

constexpr std::size_t kAxes = 3;
constexpr std::string_view kDefaultAxes = "ZXY";  // of the HERO5, which states none

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
            if (depth < kMaxKlvDepth) read_list(klv->value, depth + 1, motion);
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
