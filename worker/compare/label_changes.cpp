#include "worker/compare/label_changes.hpp"

#include <map>

#include "worker/compare/change_metric.hpp"
#include "worker/reef/population.hpp"
#include "worker/reef/population_change.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;

constexpr double kMinShare = 0.5;

// The colonies of one label.
struct LabelChange {
    std::vector<reef::Individual> areas_m2;      // of those that count
    std::vector<reef::Individual> diameters_m;   // of those that count
    std::vector<reef::Individual> on_ground_m2;  // the part of all colonies on the surveyed ground
};

const Colony* at(const std::vector<Colony>& colonies, int index) {
    return index < 0 ? nullptr : &colonies[static_cast<std::size_t>(index)];
}

// Returns the `size` of a colony at both times.
template <typename Size>
reef::Individual individual(const Colony* before, const Colony* after, const Size& size) {
    reef::Individual individual;
    if (before != nullptr) individual.before = size(*before);
    if (after != nullptr) individual.after = size(*after);
    return individual;
}

std::map<std::string, LabelChange> by_label(const ComparedColonies& colonies) {
    std::map<std::string, LabelChange> labels;
    for (const ColonyPair& pair : colonies.pairs) {
        const Colony* before = at(colonies.before, pair.before);
        const Colony* after = at(colonies.after, pair.after);
        const Colony& either = before != nullptr ? *before : *after;
        LabelChange& label = labels[either.label];
        const auto of = [&](const auto& size) { return individual(before, after, size); };
        label.on_ground_m2.push_back(of([](const Colony& c) { return c.share * c.area_m2; }));
        const double share = 0.5 * (either.share + (after != nullptr ? *after : either).share);
        if (share < kMinShare) continue;
        label.areas_m2.push_back(of([](const Colony& c) { return c.area_m2; }));
        label.diameters_m.push_back(of([](const Colony& c) { return c.diameter_m; }));
    }
    return labels;
}

std::vector<double> sizes_of(const std::vector<reef::Individual>& individuals, bool later) {
    std::vector<double> sizes;
    for (const reef::Individual& one : individuals)
        if (const auto& size = later ? one.after : one.before) sizes.push_back(*size);
    return sizes;
}

stats::Estimate over(const stats::Estimate& estimate, double surveyed_m2) {
    return {estimate.value / surveyed_m2, estimate.low / surveyed_m2, estimate.high / surveyed_m2};
}

class LabelMetrics {
public:
    LabelMetrics(const ComparedColonies& colonies, std::uint64_t seed)
        : colonies_(colonies), seed_(seed) {}

    void add(const std::string& label, const LabelChange& change) {
        whose_ = {{"label", label}};
        const double ground_m2 = colonies_.surveyed_m2;
        const auto metric = [&](const char* name,
                                const char* unit,
                                const char* method,
                                const std::vector<reef::Individual>& individuals,
                                const auto& at_one_time) {
            ChangeMetric made{name, unit, method, at_one_time(sizes_of(individuals, false))};
            if (colonies_.have_later) made.later = at_one_time(sizes_of(individuals, true));
            return made;
        };
        const stats::Estimate count = reef::count_change(change.areas_m2);
        const auto count_of = [](const auto& sizes) { return reef::poisson_count(sizes.size()); };
        put(metric("count", "", "new minus gone colonies, Poisson", change.areas_m2, count_of),
            count);
        const auto density = [&](const auto& sizes) {
            return reef::density_per_m2({sizes, {}, ground_m2});
        };
        put(metric("population_density",
                   "1/m2",
                   "new minus gone colonies over surveyed ground, Poisson",
                   change.areas_m2,
                   density),
            over(count, ground_m2));
        const auto cover_of = [&](const auto& sizes) {
            return reef::cover({sizes, {}, ground_m2});
        };
        put(metric("cover",
                   "",
                   "area of the colonies over surveyed ground, compound Poisson",
                   change.on_ground_m2,
                   cover_of),
            over(reef::sum_change(change.on_ground_m2), ground_m2));
        add_median("colony_area_median", "m2", change.areas_m2);
        add_median("colony_diameter_median", "m", change.diameters_m);
    }

    json take() { return std::move(metrics_); }

private:
    void put(const ChangeMetric& metric, const stats::Estimate& change) {
        metrics_.push_back(
            colonies_.have_later
                ? change_json(whose_, metric, change)
                : refused_change_json(
                      whose_,
                      metric,
                      "there are outlines of only one year: give those of the later dive too"));
    }

    void add_median(const char* name,
                    const char* unit,
                    const std::vector<reef::Individual>& sizes) {
        ChangeMetric metric{name, unit, "over the colonies of each year, bootstrap"};
        const auto median_of = [&](bool later) -> std::optional<stats::Estimate> {
            const std::vector<double> values = sizes_of(sizes, later);
            if (values.empty()) return std::nullopt;
            return reef::size_quantile(values, 0.5, seed_);
        };
        metric.earlier = median_of(false);
        if (colonies_.have_later) metric.later = median_of(true);
        const auto change = reef::median_change(sizes, seed_);
        if (!change && colonies_.have_later)
            metrics_.push_back(
                refused_change_json(whose_, metric, "one of the two years has no such colony"));
        else
            put(metric, change.value_or(stats::Estimate{}));
    }

    const ComparedColonies& colonies_;
    std::uint64_t seed_;
    json whose_;
    json metrics_ = json::array();
};

}  // namespace

json label_changes(const ComparedColonies& colonies, std::uint64_t seed) {
    LabelMetrics metrics(colonies, seed);
    for (const auto& [label, change] : by_label(colonies)) metrics.add(label, change);
    return metrics.take();
}

}  // namespace divemesh::compare
