#include "worker/report/svg_plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace divemesh::worker {
namespace {

constexpr double kWidth_px = 560.0;
constexpr double kHeight_px = 360.0;
constexpr double kLeft_px = 62.0;
constexpr double kRight_px = 14.0;
constexpr double kTop_px = 46.0;
constexpr double kBottom_px = 44.0;
constexpr std::size_t kMaxPoints = 1500;

std::string number(double value, int digits) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

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

// Where values lie on the picture.
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

// 1, 2 or 5 times a power of ten, at most eight of them on an axis.
double tick_step(const Range& range) {
    const double power = std::pow(10.0, std::floor(std::log10(range.size() / 8.0)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (range.size() / (factor * power) <= 8.0) return factor * power;
    return 10.0 * power;
}

std::string text_at(double x, double y, const std::string& attributes, const std::string& text) {
    return "<text x=\"" + number(x, 1) + "\" y=\"" + number(y, 1) + "\" " + attributes + ">" +
           escape_html(text) + "</text>";
}

std::string line_between(double x1, double y1, double x2, double y2, const std::string& stroke) {
    return "<line x1=\"" + number(x1, 1) + "\" y1=\"" + number(y1, 1) + "\" x2=\"" + number(x2, 1) +
           "\" y2=\"" + number(y2, 1) + "\" " + stroke + "/>";
}

// The multiples of the step within the range; zero is a plain 0.
std::vector<double> ticks(const Range& range, double step) {
    std::vector<double> values;
    const auto last = static_cast<long>(std::floor(range.high / step));
    for (auto k = static_cast<long>(std::ceil(range.low / step)); k <= last; ++k)
        values.push_back(k == 0 ? 0.0 : static_cast<double>(k) * step);
    return values;
}

std::string grid(const Axes& axes) {
    const std::string stroke = "class=\"grid\"";
    const double bottom = kHeight_px - kBottom_px;
    const double right = kWidth_px - kRight_px;
    const auto digits = [](double step) {
        return std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    };
    std::string svg;
    const double x_step = tick_step(axes.x);
    for (const double value : ticks(axes.x, x_step)) {
        const double x = axes.x_px(value);
        svg += line_between(x, kTop_px, x, bottom, stroke);
        svg += text_at(x, bottom + 15.0, "text-anchor=\"middle\"", number(value, digits(x_step)));
    }
    const double y_step = tick_step(axes.y);
    for (const double value : ticks(axes.y, y_step)) {
        const double y = axes.y_px(value);
        svg += line_between(kLeft_px, y, right, y, stroke);
        svg +=
            text_at(kLeft_px - 6.0, y + 4.0, "text-anchor=\"end\"", number(value, digits(y_step)));
    }
    return svg;
}

std::string polyline(const PlotLine& line, const Axes& axes) {
    const std::size_t count = std::min(line.x.size(), line.y.size());
    const std::size_t step = std::max<std::size_t>(1, (count + kMaxPoints - 1) / kMaxPoints);
    std::string points;
    for (std::size_t i = 0; i < count; i += step)
        points += number(axes.x_px(line.x[i]), 1) + "," + number(axes.y_px(line.y[i]), 1) + " ";
    std::string area;
    if (line.filled && count > 0)
        area = "<polygon stroke=\"none\" fill-opacity=\"0.25\" fill=\"" + escape_html(line.color) +
               "\" points=\"" + number(axes.x_px(line.x[0]), 1) + "," + number(axes.y_px(0.0), 1) +
               " " + points + number(axes.x_px(line.x[count - 1]), 1) + "," +
               number(axes.y_px(0.0), 1) + "\"/>";
    return area + "<polyline fill=\"none\" stroke-width=\"1.6\" stroke=\"" +
           escape_html(line.color) + "\" points=\"" + points + "\"/>";
}

double width_px(const PlotLine& line) { return 40.0 + 7.0 * static_cast<double>(line.name.size()); }

std::string named(const PlotLine& line, double x, double y) {
    return line_between(
               x, y, x + 18.0, y, "stroke-width=\"3\" stroke=\"" + escape_html(line.color) + "\"") +
           text_at(x + 23.0, y + 4.0, "", line.name);
}

// In a row above the plot; what has no room there in a column at its lower right.
std::string legend(const Plot& plot) {
    double row = 0.0, column = 0.0;
    for (const PlotLine& line : plot.lines) {
        row += width_px(line);
        column = std::max(column, 23.0 + 6.0 * static_cast<double>(line.name.size()));
    }
    const bool is_row = kLeft_px + row <= kWidth_px;
    double x = is_row ? kLeft_px : kWidth_px - kRight_px - column;
    double y =
        is_row ? 34.0 : kHeight_px - kBottom_px - 15.0 * static_cast<double>(plot.lines.size());
    std::string svg;
    for (const PlotLine& line : plot.lines) {
        svg += named(line, x, y);
        (is_row ? x : y) += is_row ? width_px(line) : 15.0;
    }
    return svg;
}

}  // namespace

std::string svg_plot(const Plot& plot) {
    const Axes axes = axes_of(plot);
    std::string svg = "<svg viewBox=\"0 0 " + number(kWidth_px, 0) + " " + number(kHeight_px, 0) +
                      "\" role=\"img\">";
    svg += text_at(kLeft_px, 17.0, "class=\"title\"", plot.title);
    svg += grid(axes);
    for (const PlotLine& line : plot.lines) svg += polyline(line, axes);
    svg += legend(plot);
    svg += text_at(
        0.5 * (kLeft_px + kWidth_px), kHeight_px - 8.0, "text-anchor=\"middle\"", plot.x_label);
    svg += "<g transform=\"translate(14 " + number(0.5 * (kTop_px + kHeight_px - kBottom_px), 0) +
           ") rotate(-90)\">" + text_at(0.0, 0.0, "text-anchor=\"middle\"", plot.y_label) + "</g>";
    return svg + "</svg>";
}

std::string escape_html(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        switch (c) {
            case '&': escaped += "&amp;"; break;
            case '<': escaped += "&lt;"; break;
            case '>': escaped += "&gt;"; break;
            case '"': escaped += "&quot;"; break;
            case '\'': escaped += "&#39;"; break;
            default: escaped += c;
        }
    }
    return escaped;
}

}  // namespace divemesh::worker
