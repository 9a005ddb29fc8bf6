#include "cli/import_kind.hpp"

#include <algorithm>
#include <array>

#include "schemas/error.hpp"

namespace divemesh::cli {
namespace {

struct KindWords {
    ImportKind kind;
    const char* options_of;  // "--layout is an option of ..."
    const char* found;       // "dive.bag is ..."
};

constexpr std::array<KindWords, 4> kKinds = {{
    {ImportKind::Messages, "ROS bags and MCAP", "a ROS bag or MCAP"},
    {ImportKind::Videos, "videos", "a video"},
    {ImportKind::Images, "folders of images", "a folder of images"},
    {ImportKind::CalibrationAlone, "a calibration alone", "a calibration alone"},
}};

struct OptionUse {
    const char* name;
    bool of_messages;
    bool of_videos;
    bool of_images;
    bool of_calibration;
    const char* instead;  // what to do for what does not use it
};

// The options that not everything uses. All others, such as --out, apply always.
// clang-format off
constexpr std::array<OptionUse, 12> kOptions = {{
    {"--left",             true,  false, true,  false, "the video that is given first is that of the left camera"},
    {"--right",            true,  false, true,  false, "the video that is given last is that of the right camera"},
    {"--imu",              true,  true,  true,  false, "the noise and place of an IMU are those of the calibration's files"},
    {"--rate",             false, true,  true,  false, "every image is taken"},
    {"--list",             false, false, true,  false, "the times are those of the recording"},
    {"--unit",             false, false, true,  false, "the times are those of the recording"},
    {"--bayer",            false, false, true,  false, "the recording states the format of its pixels"},
    {"--bits",             false, false, true,  false, "the recording states the format of its pixels"},
    {"--layout",           false, true,  false, false, "left and right are told by their names, or by --left and --right"},
    {"--offset",           false, true,  false, false, "times that differ by a constant are found from the images"},
    {"--uncalibrated",     false, true,  true,  false, "divemesh calibrate reads a recording of messages as it is"},
    {"--image-size",       false, false, false, true,  "the size is that of the recording's images"},
}};
// clang-format on

bool applies(const OptionUse& option, ImportKind kind) {
    switch (kind) {
        case ImportKind::Messages: return option.of_messages;
        case ImportKind::Videos: return option.of_videos;
        case ImportKind::Images: return option.of_images;
        case ImportKind::CalibrationAlone: return option.of_calibration;
    }
    return false;
}

const KindWords& words_of(ImportKind kind) {
    return *std::find_if(
        kKinds.begin(), kKinds.end(), [&](const KindWords& words) { return words.kind == kind; });
}

// Returns "videos and folders of images" for --rate.
std::string users_of(const OptionUse& option) {
    std::string text;
    for (const KindWords& words : kKinds) {
        if (!applies(option, words.kind)) continue;
        if (!text.empty()) text += " and ";
        text += words.options_of;
    }
    return text;
}

std::string options_of(ImportKind kind) {
    std::string text = "--out, --calibration, --calibration-unit";
    for (const OptionUse& option : kOptions) {
        if (!applies(option, kind)) continue;
        text += ", ";
        text += option.name;
    }
    return text;
}

[[noreturn]] void refuse(const OptionUse& option, ImportKind kind, const std::string& recording) {
    std::string text = option.name;
    text += " is an option of " + users_of(option) + ", and ";
    text += recording.empty() ? "this" : recording;
    text += std::string(" is ") + words_of(kind).found + ": leave it out (";
    text += option.instead;
    throw Error(ErrorCode::InvalidArgument, text + "); what applies is " + options_of(kind));
}

}  // namespace

void check_options_apply(const std::vector<std::string>& given,
                         ImportKind kind,
                         const std::string& recording) {
    const auto is_given = [&](const char* name) {
        return std::find(given.begin(), given.end(), name) != given.end();
    };
    for (const OptionUse& option : kOptions)
        if (is_given(option.name) && !applies(option, kind)) refuse(option, kind, recording);
}

}  // namespace divemesh::cli
