#include "tests/bench/envelope_plot.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <spdlog/fmt/fmt.h>
#include <vector>

namespace divemesh::bench {
namespace {

using nlohmann::json;

// Size and margins of one panel, px.
constexpr double kWidth = 300.0;
constexpr double kHeight = 190.0;
constexpr double kLeft = 42.0;
constexpr double kRight = 12.0;
constexpr double kTop = 26.0;
constexpr double kBottom = 44.0;
constexpr int kColumns = 3;
constexpr double kLegend = 26.0;  // height

// Decades of error, per cent of the path, from the lower edge of a panel to the upper.
constexpr double kMinDecade = -2.0;
constexpr double kMaxDecade = 2.0;
constexpr double kLost = 0.5;  // share of the frames

struct Series {
    const char* name;
    const char* error;
    const char* lost;  // share without a pose
    const char* color;
    const char* dash;
};

constexpr Series kSeries[] = {
    {"divemesh", "ate_percent", "lost_share", "#0b6fa4", ""},
    {"stated bound", "bound_percent", "lost_share", "#0b6fa4", "3 3"},
    {"SIFT and PnP", "sift_ate_percent", "sift_unlinked_share", "#b3541e", ""}};

struct Panel {
    double left;
    double top;

    double x(std::size_t step, std::size_t num_steps) const {
        const double width = kWidth - kLeft - kRight;
        return left + kLeft +
               width * (static_cast<double>(step) + 0.5) / static_cast<double>(num_steps);
    }
    double y(double decade) const {
        const double share =
            (std::clamp(decade, kMinDecade, kMaxDecade) - kMinDecade) / (kMaxDecade - kMinDecade);
        return top + kHeight - kBottom - share * (kHeight - kTop - kBottom);
    }
};

std::optional<double> decade_of(const json& row, const Series& series) {
    const json& lost = row[series.lost]["median"];
    if (lost.is_number() && lost.get<double>() > kLost) return kMaxDecade;
    const json& error = row[series.error]["median"];
    if (!error.is_number()) return std::nullopt;
    return std::log10(std::max(1e-6, error.get<double>()));
}

std::string draw_series(const Panel& panel, const json& rows, const Series& series) {
    std::string points;
    std::string dots;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto decade = decade_of(rows[i], series);
        if (!decade) continue;
        const double x = panel.x(i, rows.size());
        const double y = panel.y(*decade);
        points += fmt::format("{:.1f},{:.1f} ", x, y);
        dots += fmt::format(
            "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.2\" fill=\"{}\"/>", x, y, series.color);
    }
    return fmt::format(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" "
        "stroke-dasharray=\"{}\"/>{}\n",
        points,
        series.color,
        series.dash,
        dots);
}

std::string draw_grid(const Panel& panel) {
    std::string text;
    for (double decade = kMinDecade; decade <= kMaxDecade; ++decade) {
        const double y = panel.y(decade);
        text += fmt::format(
            "<line class=\"grid\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/><text "
            "x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n",
            panel.left + kLeft,
            panel.left + kWidth - kRight,
            y,
            y,
            panel.left + kLeft - 4.0,
            y + 4.0,
            std::pow(10.0, decade));
    }
    return text;
}

std::string draw_labels(const Panel& panel, const json& rows) {
    std::string text;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const double x = panel.x(i, rows.size());
        const double y = panel.top + kHeight - kBottom + 12.0;
        text += fmt::format(
            "<text x=\"{0:.1f}\" y=\"{1:.1f}\" text-anchor=\"end\" transform=\"rotate(-30 {0:.1f} "
            "{1:.1f})\">{2}</text>\n",
            x,
            y,
            rows[i]["step"].get<std::string>());
    }
    return text;
}

std::string draw_panel(const Panel& panel, const std::string& axis, const json& rows) {
    std::string text = fmt::format("<text class=\"title\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n",
                                   panel.left + kLeft,
                                   panel.top + 16.0,
                                   axis);
    text += draw_grid(panel) + draw_labels(panel, rows);
    for (const Series& series : kSeries) text += draw_series(panel, rows, series);
    return text;
}

std::string draw_legend() {
    std::string text;
    double x = kLeft;
    for (const Series& series : kSeries) {
        text += fmt::format(
            "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"14\" y2=\"14\" stroke=\"{}\" "
            "stroke-width=\"1.5\" stroke-dasharray=\"{}\"/><text x=\"{:.1f}\" y=\"18\">{}</text>\n",
            x,
            x + 26.0,
            series.color,
            series.dash,
            x + 31.0,
            series.name);
        x += 130.0;
    }
    return text +
           fmt::format("<text x=\"{:.1f}\" y=\"18\">error in % of the path, median</text>\n", x);
}

json rows_of(const json& steps, const std::string& axis) {
    json rows = json::array();
    for (const json& row : steps)
        if (row["axis"] == axis) rows.push_back(row);
    return rows;
}

}  // namespace

std::string envelope_plot(const json& steps, const std::vector<std::string>& axes) {
    std::string panels;
    std::size_t num = 0;
    for (const std::string& axis : axes) {
        const json rows = rows_of(steps, axis);
        if (rows.empty()) continue;
        const Panel panel{kWidth * static_cast<double>(num % kColumns),
                          kLegend + kHeight * static_cast<double>(num / kColumns)};
        panels += draw_panel(panel, axis, rows);
        ++num;
    }
    const double height = kLegend + kHeight * static_cast<double>((num + kColumns - 1) / kColumns);
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:g} {:g}\">\n"
               "<style>text{{font:10px sans-serif;fill:#415059}}.title{{font-size:12px;"
               "font-weight:600}}.grid{{stroke:#e4eaee}}</style>\n"
               "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
               kColumns * kWidth,
               height) +
           draw_legend() + panels + "</svg>\n";
}

}  // namespace divemesh::bench
