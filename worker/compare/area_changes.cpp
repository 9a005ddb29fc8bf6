#include "worker/compare/area_changes.hpp"

#include <array>
#include <map>

#include "schemas/error.hpp"
#include "worker/compare/change_metric.hpp"
#include "worker/compare/change_sums.hpp"
#include "worker/compare/label_changes.hpp"
#include "worker/compare/outlined_cells.hpp"
#include "worker/io/csv_cell.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;

constexpr double kMinCoverage = 0.5;

reef::AreaSet read_in_world(const std::filesystem::path& file) {
    reef::AreaSet set = reef::read_areas(file);
    if (set.frame != reef::AreaFrame::World)
        throw Error(ErrorCode::BadData,
                    file.string() +
                        ": its frame is ground_truth, but a comparison needs areas in the frame of "
                        "the reconstruction that they are drawn on: write \"frame\": \"world\"");
    try {
        for (const reef::Area& area : set.areas)
            if (area.kind != reef::AreaKind::Transect) outline_from_above(area);
    } catch (const Error& refused) {
        throw Error(
            refused.code(),
            file.string() + ": " + refused.what() + " (seen from above, as in a comparison)");
    }
    return set;
}

// Returns a mask (CV_8U) of the ground whose surface both dives know.
cv::Mat compared_ground(const ChangeMap& map) {
    return cells_with_value(map.change_m) & (map.state != static_cast<int>(CellState::Hidden));
}

// Returns the part of the ground in quadrats without a label; all of it if there are none.
cv::Mat in_quadrats(const reef::AreaSet& set, const RasterGrid& grid, const cv::Mat& ground) {
    cv::Mat inside = cv::Mat::zeros(ground.size(), CV_8U);
    bool any = false;
    for (const reef::Area& area : set.areas) {
        if (area.kind != reef::AreaKind::Quadrat || !area.label.empty()) continue;
        any = true;
        cells_within(outline_from_above(area), grid).add_to(inside);
    }
    return any ? cv::Mat(inside & ground) : ground;
}

class AreaMeasurer {
public:
    AreaMeasurer(const ChangeMap& map, const Changes& changes)
        : map_(map), changes_(changes), ground_(compared_ground(map)) {}

    const cv::Mat& ground() const { return ground_; }

    // Measures the three volumes of some cells (CV_8U, of the window's size).
    void measure(const json& whose,
                 const cv::Rect& window,
                 const cv::Mat& cells,
                 json& metrics) const {
        const cv::Mat seen = cells & ground_(window);
        const ChangeMap part_of_map = window_of(map_, window);
        const ChangeSums rest = sum_over(part_of_map, seen & (changes_.number(window) == 0));
        const double rest_sigma_m3 =
            std::hypot(noise_m3(rest, changes_.noise), map_.registration_sigma(rest.by_motion));
        for (const bool grown : {true, false}) {
            const double sign = grown ? 1.0 : -1.0;
            const Part part = of_patches(window, seen, grown);
            const ChangeSums sums = sum_over(part_of_map, part.cells);
            const double value = std::max(0.0, sign * sums.volume_m3);
            const double half =
                part.num_sigma *
                std::hypot(noise_m3(sums, changes_.noise),
                           map_.registration_sigma(sums.by_motion) + part.outline_m3);
            const double undetected =
                std::max(0.0, sign * rest.volume_m3 + stats::kNormal975 * rest_sigma_m3);
            metrics.push_back(change_json(
                whose,
                {grown ? "grown_volume" : "lost_volume", "m3", "of the patches within the outline"},
                {value, std::max(0.0, value - half), value + half + undetected}));
        }
        const ChangeSums net = sum_over(part_of_map, seen);
        metrics.push_back(
            change_json(whose,
                        {"net_volume", "m3", "rise minus fall of all ground that both dives saw"},
                        interval(net.volume_m3,
                                 noise_m3(net, changes_.noise),
                                 map_.registration_sigma(net.by_motion))));
    }

private:
    struct Part {
        cv::Mat cells;
        double outline_m3 = 0.0;               // standard deviation, shared by all patches
        double num_sigma = stats::kNormal975;  // the max of all patches
    };

    Part of_patches(const cv::Rect& window, const cv::Mat& seen, bool grown) const {
        Part part{cv::Mat::zeros(seen.size(), CV_8U)};
        const double cell_m2 = map_.grid.cell_m * map_.grid.cell_m;
        const cv::Mat number = changes_.number(window);
        for (int row = 0; row < seen.rows; ++row)
            for (int column = 0; column < seen.cols; ++column) {
                const int at = number.at<int>(row, column);
                if (at == 0 || seen.at<std::uint8_t>(row, column) == 0) continue;
                const ChangePatch& patch = changes_.patches[static_cast<std::size_t>(at - 1)];
                if (patch.grown != grown) continue;
                part.cells.at<std::uint8_t>(row, column) = 255;
                part.outline_m3 += cell_m2 * patch.outline_m;
                part.num_sigma = std::max(part.num_sigma, patch.num_sigma);
            }
        return part;
    }

    const ChangeMap& map_;
    const Changes& changes_;
    cv::Mat ground_;
};

json area_json(const ComparedOutline& outline, double area_m2, double coverage) {
    json entry = {{"name", outline.area.name},
                  {"mark", outline.mark},
                  {"dive", outline.dive},
                  {"kind", reef::to_string(outline.area.kind)},
                  {"area_m2", area_m2},
                  {"coverage", coverage}};
    if (!outline.area.label.empty()) entry["label"] = outline.area.label;
    return entry;
}

// The cells that all outlines of a label cover, in both years.
using LabelCells = std::map<std::string, cv::Mat>;

void measure_outlines(const std::vector<ComparedOutline>& outlines,
                      const AreaMeasurer& measurer,
                      const RasterGrid& grid,
                      LabelCells& labels,
                      json& result) {
    for (const ComparedOutline& outline : outlines) {
        const reef::Area& area = outline.area;
        const double of_outline_m2 = reef::area_m2(outline.outline);
        const OutlinedCells within = cells_within(outline.outline, grid);
        const double coverage = share_on(within, of_outline_m2, measurer.ground(), grid.cell_m);
        result["areas"].push_back(area_json(outline, of_outline_m2, coverage));
        json whose = {{"area", area.name}, {"dive", outline.dive}};
        if (!area.label.empty()) {
            whose["label"] = area.label;
            cv::Mat& cells =
                labels.try_emplace(area.label, cv::Mat::zeros(grid.rows, grid.columns, CV_8U))
                    .first->second;
            within.add_to(cells);
        }
        if (coverage < kMinCoverage) {
            for (const char* metric : {"grown_volume", "lost_volume", "net_volume"})
                result["figures"].push_back(refused_change_json(
                    whose, {metric, "m3", ""}, "both dives saw less than half of it"));
            continue;
        }
        measurer.measure(whose, within.window, within.cells, result["figures"]);
    }
}

void name_pairs(const std::vector<Colony>& before,
                const std::vector<Colony>& after,
                const std::vector<ColonyPair>& pairs,
                json& areas) {
    std::map<std::pair<std::string, std::string>, json*> entries;
    for (json& entry : areas) entries[{entry["dive"], entry["name"]}] = &entry;
    for (const ColonyPair& pair : pairs) {
        if (pair.before < 0 || pair.after < 0) continue;
        const std::string& first = before[static_cast<std::size_t>(pair.before)].name;
        const std::string& second = after[static_cast<std::size_t>(pair.after)].name;
        (*entries.at({"earlier", first}))["same_as"] = second;
        (*entries.at({"later", second}))["same_as"] = first;
    }
}

json csv_value(const json& metric, const char* time, const char* bound) {
    const auto estimate = metric.find(time);
    return estimate == metric.end() ? json() : (*estimate)[bound];
}

}  // namespace

ComparedAreas read_compared_areas(const std::filesystem::path& earlier,
                                  const std::optional<std::filesystem::path>& later) {
    ComparedAreas areas{read_in_world(earlier), std::nullopt};
    if (later) areas.later = read_in_world(*later);
    return areas;
}

std::vector<ComparedOutline> outlines_of(const ComparedAreas& areas) {
    std::vector<ComparedOutline> outlines;
    const auto add = [&](const reef::AreaSet& set, const char* dive, const char* letter) {
        int number = 0;
        for (const reef::Area& area : set.areas)
            if (area.kind != reef::AreaKind::Transect)
                outlines.push_back(
                    {area, dive, letter + std::to_string(++number), outline_from_above(area)});
    };
    add(areas.earlier, "earlier", "A");
    if (areas.later) add(*areas.later, "later", "B");
    return outlines;
}

json area_changes(const ComparedAreas& areas,
                  const ChangeMap& map,
                  const Changes& changes,
                  std::uint64_t seed) {
    const AreaMeasurer measurer(map, changes);
    LabelCells labels;
    json result = {{"areas", json::array()}, {"figures", json::array()}};
    measure_outlines(outlines_of(areas), measurer, map.grid, labels, result);
    cv::Mat surveyed = in_quadrats(areas.earlier, map.grid, measurer.ground());
    if (areas.later) surveyed = in_quadrats(*areas.later, map.grid, surveyed);
    const double surveyed_m2 = cv::countNonZero(surveyed) * map.grid.cell_m * map.grid.cell_m;
    const std::vector<Colony> before = colonies_of(areas.earlier, map.grid, surveyed);
    const std::vector<Colony> after =
        areas.later ? colonies_of(*areas.later, map.grid, surveyed) : std::vector<Colony>();
    const std::vector<ColonyPair> pairs = match_colonies(before, after);
    name_pairs(before, after, pairs, result["areas"]);
    result["surveyed_m2"] = surveyed_m2;
    if (surveyed_m2 > 0.0)
        for (json& metric :
             label_changes({before, after, pairs, surveyed_m2, areas.later.has_value()}, seed))
            result["figures"].push_back(std::move(metric));
    const cv::Rect all(0, 0, map.grid.columns, map.grid.rows);
    for (const auto& [label, cells] : labels)
        measurer.measure({{"label", label}}, all, cells, result["figures"]);
    return result;
}

std::string area_changes_csv(const json& metrics) {
    std::string csv =
        "figure,area,dive,label,unit,earlier,earlier_low,earlier_high,later,later_low,later_high,"
        "change,change_low,change_high,method,refused\n";
    for (const json& metric : metrics) {
        for (const char* key : {"figure", "area", "dive", "label", "unit"})
            csv += io::csv_cell_of(metric.value(key, json())) + ",";
        for (const char* time : {"earlier", "later", "change"})
            for (const char* bound : {"value", "low", "high"})
                csv += io::csv_cell_of(csv_value(metric, time, bound)) + ",";
        csv += io::csv_cell_of(metric.value("method", json())) + "," +
               io::csv_cell_of(metric.value("refused", json())) + "\n";
    }
    return csv;
}

}  // namespace divemesh::compare
