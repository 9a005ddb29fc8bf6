#include "tests/bench/envelope_plan.hpp"

#include <functional>
#include <spdlog/fmt/fmt.h>

namespace divemesh::bench {
namespace {

using Imu = DiveChange::Imu;

// The plain dive is rendered at this rate, and judged at every other frame of it.
constexpr double kRendered_hz = 20.0;
constexpr int kPlain = 2;

EnvelopeStep plain(const std::string& label) {
    return {.label = label, .rendered = {}, .options = {}, .change = {.keep_every = kPlain}};
}

EnvelopeStep changed(const std::string& label, const std::function<void(DiveChange&)>& change) {
    EnvelopeStep step = plain(label);
    change(step.change);
    return step;
}

// Steps of their own images, rendered at 10 Hz.
EnvelopeStep rendered(const std::string& label, std::vector<std::string> words) {
    words.insert(words.end(), {"--rate", "10"});
    return {.label = label, .rendered = std::move(words), .options = {}, .change = {}};
}

std::string number(double value) { return fmt::format("{:g}", value); }

EnvelopeAxis rendered_axis(const std::string& name,
                           const std::string& option,
                           const std::vector<double>& values,
                           const std::string& unit) {
    EnvelopeAxis axis{.name = name};
    for (const double value : values)
        axis.steps.push_back(rendered(number(value) + unit, {option, number(value)}));
    return axis;
}

EnvelopeAxis changed_axis(const std::string& name,
                          double DiveChange::*field,
                          const std::vector<double>& values,
                          const std::string& unit,
                          double shown_times = 1.0) {
    EnvelopeAxis axis{.name = name};
    for (const double value : values)
        axis.steps.push_back(changed(number(shown_times * value) + unit,
                                     [&](DiveChange& change) { change.*field = value; }));
    return axis;
}

EnvelopeAxis rates(const std::string& name, Imu imu) {
    EnvelopeAxis axis{.name = name};
    for (const int keep_every : {1, 2, 4, 8, 10, 20, 40, 80})
        axis.steps.push_back(
            changed(number(kRendered_hz / keep_every) + " Hz", [&](DiveChange& change) {
                change.keep_every = keep_every;
                change.imu = imu;
            }));
    return axis;
}

EnvelopeAxis overlaps() {
    EnvelopeAxis axis{.name = "overlap without IMU"};
    for (const double overlap : {0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2})
        axis.steps.push_back(changed(number(100.0 * overlap) + " %", [&](DiveChange& change) {
            change.overlap = overlap;
            change.imu = Imu::None;
        }));
    return axis;
}

EnvelopeAxis imus() {
    EnvelopeAxis axis{.name = "IMU", .ordered = false};
    const std::pair<const char*, Imu> kinds[] = {{"good", Imu::AsIs},
                                                 {"none", Imu::None},
                                                 {"MEMS", Imu::Mems},
                                                 {"noise stated too small", Imu::NoiseTooSmall},
                                                 {"noise stated too large", Imu::NoiseTooLarge},
                                                 {"250 ms late", Imu::Late},
                                                 {"y mirrored", Imu::Mirrored},
                                                 {"of another dive", Imu::OtherDive},
                                                 {"gyroscope stops", Imu::GyroscopeStops},
                                                 {"forces double", Imu::ForcesDouble},
                                                 {"bias jumps", Imu::BiasJumps},
                                                 {"clock jumps", Imu::ClockJumps}};
    for (const auto& [label, kind] : kinds)
        axis.steps.push_back(changed(label, [&](DiveChange& change) { change.imu = kind; }));
    return axis;
}

EnvelopeStep without_imu(EnvelopeStep step) {
    step.label += " without IMU";
    step.change.imu = Imu::None;
    return step;
}

EnvelopeAxis calibrations(const std::string& name, Imu imu) {
    EnvelopeAxis axis{.name = name};
    for (const double error : {0.0, 0.5, 1.0, 2.0, 4.0})
        axis.steps.push_back(changed(number(error) + " x", [&](DiveChange& change) {
            change.calibration_error = error;
            change.imu = imu;
        }));
    return axis;
}

EnvelopeAxis pauses() {
    EnvelopeAxis axis{.name = "stillness", .ordered = false};
    const std::pair<const char*, const char*> places[] = {{"20 s at the start", "0:20"},
                                                          {"60 s at the start", "0:60"},
                                                          {"10 s in the middle", "0.5:10"}};
    for (const auto& [label, stretch] : places) {
        axis.steps.push_back(rendered(label, {"--pauses", stretch}));
        axis.steps.push_back(without_imu(axis.steps.back()));
    }
    axis.steps.push_back(rendered("hovering for half a minute", {"--speed", "0.05"}));
    axis.steps.back().length_m = 2.0;  // nearly all of it sway
    axis.steps.push_back(without_imu(axis.steps.back()));
    return axis;
}

EnvelopeAxis straight_lines() {
    EnvelopeAxis axis{.name = "straight line", .ordered = false, .steps = {}, .scene = "transect"};
    for (const char* sway : {"1", "0.25", "0"}) {
        axis.steps.push_back(rendered(std::string("sway times ") + sway, {"--sway", sway}));
        axis.steps.push_back(without_imu(axis.steps.back()));
    }
    axis.steps.push_back(rendered("sway times 0 for a minute", {"--sway", "0"}));
    axis.steps.back().length_m = 16.0;
    axis.steps.push_back(without_imu(axis.steps.back()));
    return axis;
}

// Its dives have masks, which tell the share of the image.
EnvelopeAxis moving_things() {
    EnvelopeAxis axis{.name = "moving things"};
    for (const char* density : {"5", "20", "50", "100", "200"})
        axis.steps.push_back(
            rendered(std::string(density) + " x the fish", {"--fish-density", density, "--truth"}));
    return axis;
}

EnvelopeAxis blue_water(const std::string& name, double at_share) {
    EnvelopeAxis axis{.name = name};
    for (const double duration_s : {0.5, 1.0, 2.0, 4.0, 6.0})
        axis.steps.push_back(changed(number(duration_s) + " s", [&](DiveChange& change) {
            change.blue_at_share = at_share;
            change.blue_s = duration_s;
        }));
    return axis;
}

}  // namespace

const std::vector<EnvelopeAxis>& envelope_axes() {
    static const std::vector<EnvelopeAxis> axes = {
        rates("rate", Imu::AsIs),
        rates("rate without IMU", Imu::None),
        overlaps(),
        rendered_axis("turning", "--swing", {20, 40, 60, 90, 120, 180}, " deg/s"),
        calibrations("calibration error", Imu::AsIs),
        calibrations("calibration error without IMU", Imu::None),
        changed_axis("vertical misalignment",
                     &DiveChange::vertical_misalignment_px,
                     {0.5, 1, 2, 4, 8, 16},
                     " px"),
        imus(),
        pauses(),
        straight_lines(),
        rendered_axis("light", "--light", {0.3, 0.1, 0.03, 0.01, 0.003}, " x"),
        rendered_axis("turbidity", "--turbidity", {1.5, 2, 3, 4, 6}, " x"),
        rendered_axis("texture", "--texture-contrast", {0.5, 0.25, 0.1, 0.05, 0}, " x"),
        rendered_axis("snow", "--snow-density", {3, 10, 30, 100}, " x"),
        moving_things(),
        changed_axis("exposure of the right camera",
                     &DiveChange::right_exposure,
                     {0.8, 0.5, 0.25, 0.1},
                     " x"),
        rendered_axis("stereo offset", "--stereo-offset", {1, 2, 5, 10, 20, 50}, " ms"),
        changed_axis(
            "dropped frames", &DiveChange::dropped_share, {0.1, 0.3, 0.5, 0.7, 0.9}, " %", 100.0),
        changed_axis(
            "doubled frames", &DiveChange::doubled_share, {0.1, 0.3, 0.5, 0.7}, " %", 100.0),
        changed_axis("gap", &DiveChange::gap_s, {0.5, 1, 2, 4, 8}, " s"),
        blue_water("blue water", 0.4),
        blue_water("blue water first", 0.0),
    };
    return axes;
}

EnvelopeScale whole_envelope() {
    return {
        .scenes = {"barge", "reef"}, .seeds = {61, 62, 63}, .plain_length_m = 8.0, .length_m = 4.0};
}

EnvelopeScale quick_envelope() {
    return {.scenes = {"barge"}, .seeds = {61}, .plain_length_m = 5.0, .length_m = 2.0};
}

}  // namespace divemesh::bench
