#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/compare/change_patches.hpp"
#include "worker/reef/area_set.hpp"
#include "worker/reef/polygon.hpp"

namespace divemesh::compare {

// Outlines of the compared place, in the earlier dive's frame.
struct ComparedAreas {
    reef::AreaSet earlier;  // drawn on the earlier dive
    std::optional<reef::AreaSet>
        later;  // drawn on the later; nullopt: the earlier ones apply to both
};

// Reads the outlines. Throws as read_areas() does, and Error{BadData} for a file whose areas are
// not in the frame of the reconstruction or have no area from above.
ComparedAreas read_compared_areas(const std::filesystem::path& earlier,
                                  const std::optional<std::filesystem::path>& later);

// A quadrat or a polygon as seen from above.
struct ComparedOutline {
    const reef::Area& area;
    const char* dive;  // "earlier" or "later": the dive that it was drawn on
    std::string mark;  // in figures and tables: A1, A2 ... of the earlier, B1 ... of the later
    reef::Polygon outline;
};

// Returns all outlines, those of the earlier dive first. They refer to `areas`.
std::vector<ComparedOutline> outlines_of(const ComparedAreas& areas);

// Returns {"areas": [{name, mark, dive: "earlier" | "later", kind, label?, area_m2, coverage,
// same_as?}], "surveyed_m2", "figures": [{figure, area?, dive?, label?, unit, earlier?, later?,
// change, method} | {figure, area?, dive?, label?, unit, refused}]} where earlier, later and change
// have value, low and high (95 %). Each quadrat and polygon has `grown_volume`, `lost_volume` (of
// the patches, within the outline) and `net_volume` (of all that both dives saw in it). Each label
// has the same of all its outlines together, and `count`, `population_density`, `cover`,
// `colony_area_median` and `colony_diameter_median` with their change, over the ground that both
// dives saw: of the quadrats without a label of either file, otherwise all of it.
nlohmann::json area_changes(const ComparedAreas& areas,
                            const ChangeMap& map,
                            const Changes& changes,
                            std::uint64_t seed);

// Returns a header and a row per metric: figure, area, dive, label, unit, then value, low and high
// of earlier, later and change, method, refused (RFC 4180; lines end with \n).
std::string area_changes_csv(const nlohmann::json& metrics);

}  // namespace divemesh::compare
