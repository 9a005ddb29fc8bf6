#include "worker/report/svg_plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "worker/base/text.hpp"
#include "worker/report/html_template.hpp"
#include "worker/report/html_templates.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

constexpr double kWidth_px = 560.0;
constexpr double kHeight_px = 360.0;
constexpr double kLeft_px = 62.0;
constexpr double kRight_px = 14.0;
constexpr double kTop_px = 46.0;
constexpr double kBottom_px = 44.0;
constexpr std::size_t kMaxPoints = 1500;

struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void add(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    double size() const { return high - low; }
    void grow_to(double wanted) {
        const double middle = 0.5 * (low + high);
        low = middle - 0.5 * wanted;
        high = middle + 0.5 * wanted;
    }
};

// Maps values to pixels of the plot.
struct Axes {
    Range x;
    Range y;

    double x_px(double value) const {
        return kLeft_px + (value - x.low) / x.size() * (kWidth_px - kLeft_px - kRight_px);
    }
    double y_px(double value) const {
        return kHeight_px - kBottom_px -
               (value - y.low) / y.size() * (kHeight_px - kTop_px - kBottom_px);
    }
};

Range padded(Range range) {
    if (!(range.low <= range.high)) range = {0.0, 1.0};
    range.grow_to(range.size() > 0.0 ? 1.06 * range.size() : 1.0);
    return range;
}

Axes axes_of(const Plot& plot) {
    Axes axes;
    for (const PlotLine& line : plot.lines) {
        for (const double x : line.x) axes.x.add(x);
        for (const double y : line.y) axes.y.add(y);
    }
    if (!plot.equal_scale) axes.y.add(0.0);
    axes.x = padded(axes.x);
    axes.y = padded(axes.y);
    if (!plot.equal_scale) return axes;
    const double per_px = std::max(axes.x.size() / (kWidth_px - kLeft_px - kRight_px),
                                   axes.y.size() / (kHeight_px - kTop_px - kBottom_px));
    axes.x.grow_to(per_px * (kWidth_px - kLeft_px - kRight_px));
    axes.y.grow_to(per_px * (kHeight_px - kTop_px - kBottom_px));
    return axes;
}

// Returns 1, 2 or 5 times a power of ten, for at most eight ticks on an axis.
double tick_step(const Range& range) {
    const double power = std::pow(10.0, std::floor(std::log10(range.size() / 8.0)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (range.size() / (factor * power) <= 8.0) return factor * power;
    return 10.0 * power;
}

// Returns the multiples of the step within the range; zero is never -0.
std::vector<double> ticks(const Range& range, double step) {
    std::vector<double> values;
    const auto last = static_cast<long>(std::floor(range.high / step));
    for (auto k = static_cast<long>(std::ceil(range.low / step)); k <= last; ++k)
        values.push_back(k == 0 ? 0.0 : static_cast<double>(k) * step);
    return values;
}

// Returns the tick at `at_px` along its axis.
json tick(double at_px, double value, double step) {
    const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    return {{"at", base::fixed(at_px, 1)}, {"value", base::fixed(value, digits)}};
}

json x_ticks(const Axes& axes) {
    json list = json::array();
    const double step = tick_step(axes.x);
    for (const double value : ticks(axes.x, step))
        list.push_back(tick(axes.x_px(value), value, step));
    return list;
}

json y_ticks(const Axes& axes) {
    json list = json::array();
    const double step = tick_step(axes.y);
    for (const double value : ticks(axes.y, step)) {
        list.push_back(tick(axes.y_px(value), value, step));
        list.back()["baseline"] = base::fixed(axes.y_px(value) + 4.0, 1);
    }
    return list;
}

json polyline(const PlotLine& line, const Axes& axes) {
    const std::size_t count = std::min(line.x.size(), line.y.size());
    const std::size_t step = std::max<std::size_t>(1, (count + kMaxPoints - 1) / kMaxPoints);
    std::string points;
    for (std::size_t i = 0; i < count; i += step)
        points +=
            base::fixed(axes.x_px(line.x[i]), 1) + "," + base::fixed(axes.y_px(line.y[i]), 1) + " ";
    json filled;
    if (line.filled && count > 0)
        filled = {{"first", base::fixed(axes.x_px(line.x[0]), 1)},
                  {"last", base::fixed(axes.x_px(line.x[count - 1]), 1)},
                  {"zero", base::fixed(axes.y_px(0.0), 1)}};
    return {{"color", line.color}, {"points", points}, {"filled", filled}};
}

double width_px(const PlotLine& line) { return 40.0 + 7.0 * static_cast<double>(line.name.size()); }

json named(const PlotLine& line, double x, double y) {
    return {{"name", line.name},
            {"color", line.color},
            {"x", base::fixed(x, 1)},
            {"x_end", base::fixed(x + 18.0, 1)},
            {"x_name", base::fixed(x + 23.0, 1)},
            {"y", base::fixed(y, 1)},
            {"baseline", base::fixed(y + 4.0, 1)}};
}

// Puts entries in a row above the plot; those without room there in a column at its lower right.
json legend(const Plot& plot) {
    double row = 0.0, column = 0.0;
    for (const PlotLine& line : plot.lines) {
        row += width_px(line);
        column = std::max(column, 23.0 + 6.0 * static_cast<double>(line.name.size()));
    }
    const bool is_row = kLeft_px + row <= kWidth_px;
    double x = is_row ? kLeft_px : kWidth_px - kRight_px - column;
    double y =
        is_row ? 34.0 : kHeight_px - kBottom_px - 15.0 * static_cast<double>(plot.lines.size());
    json list = json::array();
    for (const PlotLine& line : plot.lines) {
        list.push_back(named(line, x, y));
        (is_row ? x : y) += is_row ? width_px(line) : 15.0;
    }
    return list;
}

}  // namespace

std::string svg_plot(const Plot& plot) {
    const Axes axes = axes_of(plot);
    const double bottom = kHeight_px - kBottom_px;
    json values = {{"title", plot.title},
                   {"x_label", plot.x_label},
                   {"y_label", plot.y_label},
                   {"x_ticks", x_ticks(axes)},
                   {"y_ticks", y_ticks(axes)},
                   {"legend", legend(plot)},
                   {"width", base::fixed(kWidth_px, 0)},
                   {"height", base::fixed(kHeight_px, 0)},
                   {"left", base::fixed(kLeft_px, 1)},
                   {"right", base::fixed(kWidth_px - kRight_px, 1)},
                   {"top", base::fixed(kTop_px, 1)},
                   {"bottom", base::fixed(bottom, 1)},
                   {"below", base::fixed(bottom + 15.0, 1)},
                   {"beside", base::fixed(kLeft_px - 6.0, 1)},
                   {"foot", base::fixed(kHeight_px - 8.0, 1)},
                   {"x_label_at", base::fixed(0.5 * (kLeft_px + kWidth_px), 1)},
                   {"y_label_at", base::fixed(0.5 * (kTop_px + bottom), 0)}};
    values["lines"] = json::array();
    for (const PlotLine& line : plot.lines) values["lines"].push_back(polyline(line, axes));
    return fill_template(plot_svg(), values);
}

}  // namespace divemesh::report
