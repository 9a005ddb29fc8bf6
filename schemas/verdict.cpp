#include "schemas/verdict.hpp"

#include <algorithm>

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<Verdict> kTexts[] = {
    {Verdict::Good, "good"},
    {Verdict::UsableWithRestrictions, "usable_with_restrictions"},
    {Verdict::NotUsable, "not_usable"},
};

struct Row {
    std::string_view code;  // of a warning; a leading "_" stands for any sensor before it
    std::string_view restricts;
};

// Warnings that are not listed restrict "accuracy".
// clang-format off
constexpr Row kRows[] = {
    {"tracking_lost",               "path"},
    {"dive_in_segments",            "path"},
    {"images_unusable",             "path"},
    {"clocks_disagree",             "path"},
    {"drift_may_be_large",          "path"},
    {"loops_not_taken",             "path"},
    {"loops_not_converged",         "path"},
    {"solver_failed",               "path"},
    {"solver_not_converged",        "path"},
    {"adjustment_not_converged",    "path"},
    {"adjustment_not_taken",        "path"},
    {"gyro_vision_mismatch",        "path"},
    {"stereo_mismatch",             "scale"},
    {"rig_moved",                   "scale"},
    {"alignment_not_converged",     "scale"},
    {"calibration_medium",          "scale"},
    {"calibration_resized",         "scale"},
    {"water_not_stated",            "scale"},
    {"scale_untested",              "scale"},
    {"scale_uncertain",             "scale"},
    {"stereo_unmatched",            "accuracy"},
    {"scale_contradicted",          "scale"},
    {"scale_off",                   "scale"},
    {"scale_not_corrected",         "scale"},
    {"scale_corrected",             "scale"},
    {"scene_too_near",              "surface"},
    {"depth_left_out",              "surface"},
    {"camera_unsharp",              "surface"},
    {"images_bayer",                "surface"},
    {"images_soft",                 "surface"},
    {"rolling_shutter",             "surface"},
    {"images_featureless",          "surface"},
    {"vertical_unknown",            "surface"},
    {"surface_incomplete",          "surface"},
    {"positions_left_out",          "place"},
    {"positions_untested",          "place"},
    {"positions_not_joined",        "place"},
    {"bounds_unknown",              "accuracy"},
    {"calibration_not_converged",   "accuracy"},
    {"calibration_not_taken",       "accuracy"},

    // What these say of the recording matters only where it shows in the result, and then there is
    // a finding on the result.
    {"_gap",                        ""},
    {"_partial",                    ""},
    {"clock_set_back",              ""},
    {"recording_paused",            ""},
    {"camera_clocks_differ",        ""},
    {"further_dive",                ""},
    {"image_repeated",              ""},
    {"image_list_missing",          ""},
    {"image_names_completed",       ""},
    {"images_fixed_pattern",        ""},
    {"_row_malformed",              ""},
    {"_not_finite",                 ""},
    {"_timestamp_repeated",         ""},
    {"_timestamp_backwards",        ""},
    {"imu_zeros",                   ""},
    {"imu_frozen",                  ""},
    {"pressure_sign",               ""},
    {"gravity_upside_down",         ""},
    {"imu_left_out",                ""},
    {"imu_left_out_for_a_time",     ""},
    {"accelerometer_left_out",      ""},
    {"ahrs_left_out",               ""},
    {"ahrs_jump",                   ""},
    {"ahrs_left_out_for_a_time",    ""},
    {"pressure_left_out",           ""},
    {"positions_contradict_path",   "path"},
    {"imu_clock_offset",            ""},
    {"imu_lever_arm",               ""},
    {"frames_skipped",              ""},
    {"frames_unmatched",            ""},
    {"image_16_bit",                ""},
    {"images_dark",                 ""},
    {"file_left_out",               ""},
    {"video_chapter_missing",       ""},
    {"video_chapter_unusable",      ""},
    {"gravity_check",               ""},
    {"imu_missing",                 ""},
    {"imu_slow",                    ""},
    {"mounting_assumed",            ""},
    {"sensor_left_out",             ""},
    {"camera_left_out",             ""},

    // These concern what the result is compared with, or extras.
    {"ground_truth_unusable",       ""},
    {"surface_not_measured",        ""},
    {"measurement_incomplete",      ""},
    {"position_unusable",           ""},
    {"truth_set_aside",             ""},
    {"texture_incomplete",          ""},
    {"color_not_restored",          ""},
    {"color_partly_restored",       ""},
};
// clang-format on

bool matches(const Row& row, std::string_view code) {
    return row.code.starts_with('_') ? code.ends_with(row.code) : code == row.code;
}

}  // namespace

std::string_view to_string(Verdict verdict) { return enum_to_text(kTexts, verdict); }

Verdict verdict_from_string(std::string_view text) {
    return enum_from_text<Verdict>(kTexts, text, "verdict");
}

std::optional<Finding> first_error(const std::vector<Finding>& findings) {
    const auto error = std::find_if(findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.severity == Severity::Error;
    });
    return error == findings.end() ? std::nullopt : std::optional(*error);
}

std::string_view restriction_of(const Finding& finding) {
    if (finding.severity == Severity::Error) return "all";
    if (finding.severity == Severity::Info) return "";
    const auto* const row = std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& of) {
        return matches(of, finding.code);
    });
    return row == std::end(kRows) ? "accuracy" : row->restricts;
}

std::vector<std::string_view> restrictions_of(const std::vector<Finding>& findings) {
    if (has_error(findings)) return {"all"};
    std::vector<std::string_view> result;
    for (const Finding& finding : findings) {
        const std::string_view restricts = restriction_of(finding);
        if (!restricts.empty() &&
            std::find(result.begin(), result.end(), restricts) == result.end())
            result.push_back(restricts);
    }
    return result;
}

Verdict verdict_on(const std::vector<Finding>& findings) {
    if (has_error(findings)) return Verdict::NotUsable;
    return restrictions_of(findings).empty() ? Verdict::Good : Verdict::UsableWithRestrictions;
}

}  // namespace divemesh
