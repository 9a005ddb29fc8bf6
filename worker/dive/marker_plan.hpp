#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/dive/marker_family.hpp"

namespace divemesh::dive {

// Corners as somebody sees them who reads the tag upright, counter-clockwise.
enum class TagCorner { BottomLeft, BottomRight, TopRight, TopLeft };
inline constexpr std::size_t kNumTagCorners = 4;

std::string_view to_string(TagCorner corner);  // bottom_left, ...

// An end of a scale bar: the middle of a tag, or one of its corners.
struct MarkerPoint {
    int id = 0;
    std::optional<TagCorner> corner;
};
std::string to_string(const MarkerPoint& point);  // "7", "7 top_left"

// A distance between two points of tags that is known from elsewhere.
struct ScaleBar {
    std::string name;
    MarkerPoint from;
    MarkerPoint to;
    double distance_m = 0.0;
    double sigma_m = 0.0;  // of the known distance; 0: taken as exact
};

// Which tags lie in the scene and what is known of them: markers.json, completed by the options.
struct MarkerPlan {
    MarkerFamily family = MarkerFamily::Tag36h11;
    std::optional<double> size_m;   // of every tag that has none of its own
    double size_sigma_m = 0.0;      // of printed sizes; 0: taken as exact
    std::map<int, double> sizes_m;  // by id
    std::vector<ScaleBar> scale_bars;

    std::optional<double> size_of(int id) const;
    bool names(int id) const;  // whether something is said of this tag
};

// markers.json as docs/markers.md describes it. Throws InvalidInput with everything that is wrong,
// each with the field's name and its JSON pointer.
MarkerPlan marker_plan_from_json(const nlohmann::json& document);
nlohmann::json to_json(const MarkerPlan& plan);

// What the dive says, with what the options say in its place. Nothing when neither names a family:
// then nobody looks for tags. Throws Error{InvalidArgument} for an unknown family.
std::optional<MarkerPlan> marker_plan_of(const std::optional<MarkerPlan>& of_dive,
                                         const ReconstructionOptions& options);

}  // namespace divemesh::dive
