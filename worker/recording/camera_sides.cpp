#include "worker/recording/camera_sides.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <utility>

#include "schemas/error.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/image_folders.hpp"

namespace divemesh::recording {
namespace {

constexpr std::string_view kRemedy =
    ": give two folders, the left one first, or name the folders by --left and --right";
constexpr std::size_t kMaxPlacesTold = 4;
constexpr std::size_t kMinPlaceShare = 10;  // a tenth of the images is a recording of its own
constexpr std::size_t kMinShare = 3;  // a rule tells apart a third of all images, or it is chance

// A run of letters or of digits in a name.
struct Token {
    std::size_t begin = 0;
    std::size_t end = 0;
    bool is_number = false;
};

// The words for both cameras: of letters alone, or one with the numbers of the cameras behind it.
// Numbers at the end of file names have no word.
struct SideRule {
    std::string_view left;
    std::string_view right;
    int left_number = -1;  // -1: the words differ
    int right_number = -1;

    std::string text() const {
        if (left_number < 0) return std::string(left) + " and " + std::string(right);
        std::string both(left);
        both += left.empty() ? "_" : "";
        return both + std::to_string(left_number) + " and " + both + std::to_string(right_number);
    }
};
// Colour comes before grey: KITTI's cameras 2 and 3 are those in colour.
constexpr std::array kRules = {
    SideRule{"left", "right"},
    SideRule{"l", "r"},
    SideRule{"image", "image", 2, 3},
    SideRule{"image", "image", 0, 1},
    SideRule{"cam", "cam", 0, 1},
    SideRule{"camera", "camera", 0, 1},
    SideRule{"cam", "cam", 1, 2},
    SideRule{"camera", "camera", 1, 2},
    SideRule{"infra", "infra", 1, 2},
    SideRule{"fisheye", "fisheye", 1, 2},
    SideRule{"", "", 0, 1},
};

// Where a name states its camera.
struct SideMatch {
    Side side = Side::Left;
    std::size_t begin = 0;
    std::size_t end = 0;
};

std::vector<Token> tokens_of(std::string_view lower) {
    const auto kind = [&](std::size_t i) {
        const char c = lower[i];
        return c >= '0' && c <= '9' ? 'd' : c >= 'a' && c <= 'z' ? 'l' : ' ';
    };
    std::vector<Token> tokens;
    for (std::size_t i = 0; i < lower.size(); ++i) {
        const bool goes_on = !tokens.empty() && tokens.back().end == i && kind(i) == kind(i - 1);
        if (goes_on)
            ++tokens.back().end;
        else if (kind(i) != ' ')
            tokens.push_back({i, i + 1, kind(i) == 'd'});
    }
    return tokens;
}

std::string_view text_of(std::string_view lower, const Token& token) {
    return lower.substr(token.begin, token.end - token.begin);
}

// A name in lower case without its extension, and its tokens.
struct TokenedName {
    explicit TokenedName(std::string_view name) : lower(lower_case(name)) {
        file_at = folder_of(lower).size();
        lower.resize(file_at + stem_of(lower).size());
        tokens = tokens_of(lower);
    }
    std::string_view text(std::size_t token) const { return text_of(lower, tokens[token]); }
    // Returns the number of a token that directly follows the one before, or behind one separator.
    std::optional<std::int64_t> number_behind(std::size_t token) const {
        const std::size_t next = token + 1;
        if (next >= tokens.size() || !tokens[next].is_number) return std::nullopt;
        const std::string_view gap = std::string_view(lower).substr(
            tokens[token].end, tokens[next].begin - tokens[token].end);
        if (!gap.empty() && gap != "_" && gap != "-") return std::nullopt;
        return dive::parse_integer(text(next));
    }

    std::string lower;
    std::size_t file_at = 0;  // where the file's own name begins
    std::vector<Token> tokens;
};

std::optional<SideMatch> match_of(std::int64_t number, const SideRule& rule, Token range) {
    if (number == rule.left_number) return SideMatch{Side::Left, range.begin, range.end};
    if (number == rule.right_number) return SideMatch{Side::Right, range.begin, range.end};
    return std::nullopt;
}

// Returns the camera by a single digit at the end of a file's name that has another number before.
std::optional<SideMatch> match_at_end(const TokenedName& name, const SideRule& rule) {
    if (name.tokens.size() < 2) return std::nullopt;
    const Token& last = name.tokens.back();
    const bool is_digit = last.is_number && last.end - last.begin == 1;
    const bool is_in_file = last.begin > name.file_at && last.end == name.lower.size();
    const bool has_number =
        std::any_of(name.tokens.begin(), name.tokens.end() - 1, [&](const Token& token) {
            return token.is_number && token.begin >= name.file_at;
        });
    if (!is_digit || !is_in_file || !has_number) return std::nullopt;
    return match_of(name.lower.back() - '0', rule, last);
}

// Returns the last place of a name that states its camera.
std::optional<SideMatch> find_match(const TokenedName& name, const SideRule& rule) {
    if (rule.left.empty()) return match_at_end(name, rule);
    for (std::size_t i = name.tokens.size(); i-- > 0;) {
        const Token& token = name.tokens[i];
        if (rule.left_number < 0) {
            if (name.text(i) == rule.left) return SideMatch{Side::Left, token.begin, token.end};
            if (name.text(i) == rule.right) return SideMatch{Side::Right, token.begin, token.end};
            continue;
        }
        // In the names of files the number behind "image" counts them.
        const bool may_count = token.begin >= name.file_at && rule.left == "image";
        const auto number =
            name.text(i) == rule.left && !may_count ? name.number_behind(i) : std::nullopt;
        if (!number) continue;
        if (auto match = match_of(*number, rule, {token.begin, name.tokens[i + 1].end, true}))
            return match;
    }
    return std::nullopt;
}

SidedImage sided(const std::string& name, std::size_t begin, std::size_t end) {
    const std::size_t file_at = folder_of(name).size();
    std::string stem(stem_of(name));
    if (begin >= file_at) stem.erase(begin - file_at, end - begin);
    return {name, std::move(stem)};
}

// Counts how many images of each camera every rule finds, and returns the one that finds most
// pairs.
const SideRule& best_rule(const std::vector<std::string>& images) {
    std::array<std::size_t, kRules.size()> num_left{};
    std::array<std::size_t, kRules.size()> num_right{};
    for (const std::string& image : images) {
        const TokenedName name(image);
        for (std::size_t i = 0; i < kRules.size(); ++i)
            if (const auto match = find_match(name, kRules[i]))
                ++(match->side == Side::Left ? num_left : num_right)[i];
    }
    std::size_t best = 0;
    const auto num_pairs = [&](std::size_t i) { return std::min(num_left[i], num_right[i]); };
    for (std::size_t i = 1; i < kRules.size(); ++i)
        if (num_pairs(i) > num_pairs(best)) best = i;
    const std::size_t num_told = num_left[best] + num_right[best];
    if (num_pairs(best) > 0 && num_told * kMinShare >= images.size()) return kRules[best];
    throw Error(ErrorCode::InvalidArgument,
                "the names of the " + std::to_string(images.size()) +
                    " images do not tell left from right, as left and right, L and R, cam0 and "
                    "cam1 or _0 and _1 do" +
                    std::string(kRemedy));
}

using SidesByPlace = std::map<std::string, CameraSides>;

std::size_t num_images(const CameraSides& sides) { return sides.left.size() + sides.right.size(); }

// Puts all images into one recording if no folder holds images of both cameras.
void join_single_sides(SidesByPlace& places) {
    for (const auto& [place, sides] : places)
        if (!sides.left.empty() && !sides.right.empty()) return;
    CameraSides joined;
    for (const auto& [place, sides] : places) {
        joined.left.insert(joined.left.end(), sides.left.begin(), sides.left.end());
        joined.right.insert(joined.right.end(), sides.right.begin(), sides.right.end());
    }
    places = {{"", std::move(joined)}};
}

// Returns the recording of the folder with the most images. A few images elsewhere, such as
// vignettes, are none; several recordings are refused.
CameraSides only_recording(SidesByPlace& places) {
    const auto largest =
        std::max_element(places.begin(), places.end(), [](const auto& a, const auto& b) {
            return num_images(a.second) < num_images(b.second);
        });
    std::string told;
    std::size_t num_recordings = 0;
    for (const auto& [place, sides] : places) {
        if (num_images(sides) * kMinPlaceShare < num_images(largest->second)) continue;
        if (++num_recordings > kMaxPlacesTold) continue;
        told += ' ';
        told += place.empty() ? "./" : dive::printable(place);
    }
    if (num_recordings == 1) return std::move(largest->second);
    throw Error(ErrorCode::InvalidArgument,
                "there are left and right images in " + std::to_string(num_recordings) +
                    " folders:" + told + ": import one of them at a time");
}

CameraSides by_names(const std::vector<std::string>& images) {
    const SideRule& rule = best_rule(images);
    SidesByPlace places;
    for (const std::string& image : images) {
        const auto match = find_match(TokenedName(image), rule);
        if (!match) continue;
        const std::string_view before = std::string_view(image).substr(0, match->begin);
        CameraSides& sides = places[std::string(folder_of(before))];
        auto& side = match->side == Side::Left ? sides.left : sides.right;
        side.push_back(sided(image, match->begin, match->end));
    }
    join_single_sides(places);
    CameraSides sides = only_recording(places);
    sides.rule = rule.text();
    return sides;
}

// Returns what comes before a folder in the name of an image in it; nullopt if it is not in it.
std::optional<std::string> place_before(std::string_view name, std::string folder) {
    while (folder.ends_with('/')) folder.pop_back();
    folder += '/';
    if (name.starts_with(folder)) return "";
    const std::size_t at = name.find("/" + folder);
    if (at == std::string_view::npos) return std::nullopt;
    return std::string(name.substr(0, at + 1));
}

CameraSides by_folders(const std::vector<std::string>& images, const NamedFolders& named) {
    if (named.left.empty() || named.right.empty() || named.left == named.right)
        throw Error(ErrorCode::InvalidArgument,
                    "one camera alone is named: name the folders of both by --left and --right");
    SidesByPlace places;
    for (const std::string& image : images) {
        if (const auto place = place_before(image, named.left))
            places[*place].left.push_back(sided(image, 0, 0));
        if (const auto place = place_before(image, named.right))
            places[*place].right.push_back(sided(image, 0, 0));
    }
    join_single_sides(places);
    CameraSides sides = only_recording(places);
    sides.rule = dive::printable(named.left) + " and " + dive::printable(named.right);
    if (sides.left.empty() || sides.right.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "there is no image in " +
                        dive::printable(sides.left.empty() ? named.left : named.right) +
                        ": name a folder of the recording that holds images");
    return sides;
}

}  // namespace

CameraSides find_camera_sides(const std::vector<std::string>& images,
                              const NamedFolders& named,
                              dive::FindingLog& findings) {
    if (images.empty())
        throw Error(ErrorCode::BadData,
                    "there is no image: give a folder of PNG, JPEG, TIFF, BMP, PGM or PPM files");
    const bool is_named = !named.left.empty() || !named.right.empty();
    CameraSides sides = is_named ? by_folders(images, named) : by_names(images);
    const auto num_other = std::ssize(images) - std::ssize(sides.left) - std::ssize(sides.right);
    if (num_other > 0)
        findings.info("images_left_out",
                      "",
                      std::to_string(num_other) + " images are of neither camera (" + sides.rule +
                          "): they are not used");
    return sides;
}

std::optional<int> camera_number(std::string_view image) {
    const TokenedName name(folder_of(image));
    for (std::size_t i = name.tokens.size(); i-- > 0;) {
        if (name.text(i) != "image" && name.text(i) != "cam") continue;
        const auto number = name.number_behind(i);
        if (number && *number >= 0 && *number < 100) return static_cast<int>(*number);
    }
    return std::nullopt;
}

}  // namespace divemesh::recording
