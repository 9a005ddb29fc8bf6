#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/dive/marker_family.hpp"

namespace divemesh::dive {

// Corners of an upright tag as a person reads it, counter-clockwise.
enum class TagCorner { BottomLeft, BottomRight, TopRight, TopLeft };
inline constexpr std::size_t kNumTagCorners = 4;

std::string_view to_string(TagCorner corner);  // bottom_left, ...

// An end of a scale bar: the centre of a tag or one of its corners.
struct MarkerPoint {
    int id = 0;
    std::optional<TagCorner> corner;
};
std::string to_string(const MarkerPoint& point);  // "7", "7 top_left"

// A distance between two points of tags that is known from another source.
struct ScaleBar {
    std::string name;
    MarkerPoint from;
    MarkerPoint to;
    double distance_m = 0.0;
    double sigma_m = 0.0;  // of the known distance; 0: exact
};

// The tags that lie in the scene and what is known of them: markers.json, completed by the options.
struct MarkerPlan {
    MarkerFamily family = MarkerFamily::Tag36h11;
    std::optional<double> size_m;   // of every tag without an own size
    double size_sigma_m = 0.0;      // of printed sizes; 0: exact
    std::map<int, double> sizes_m;  // by id
    std::vector<ScaleBar> scale_bars;

    std::optional<double> size_of(int id) const;
    bool names(int id) const;  // whether the plan mentions this tag
};

// Parses markers.json as described in docs/markers.md. Throws InvalidInput with all mistakes, each
// with the field's name and its JSON pointer.
MarkerPlan marker_plan_from_json(const nlohmann::json& document);
nlohmann::json to_json(const MarkerPlan& plan);

// Returns the plan of the dive, overridden by the options; nullopt if neither names a family, in
// which case tags are not searched. Throws Error{InvalidArgument} for an unknown family.
std::optional<MarkerPlan> marker_plan_of(const std::optional<MarkerPlan>& of_dive,
                                         const ReconstructionOptions& options);

}  // namespace divemesh::dive
