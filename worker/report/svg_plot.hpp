#pragma once

#include <string>
#include <vector>

namespace divemesh::report {

// One line of a plot; `x` and `y` have the same length.
struct PlotLine {
    std::string name;
    std::string color;  // CSS
    std::vector<double> x;
    std::vector<double> y;
    bool filled = false;  // down to zero
};

struct Plot {
    std::string title;
    std::string x_label;
    std::string y_label;
    std::vector<PlotLine> lines;
    bool equal_scale = false;  // a metre has the same length on both axes
};

// Returns one inline <svg> with axes, ticks and a legend. Long lines are thinned to what is
// visible. Texts are escaped.
std::string svg_plot(const Plot& plot);

}  // namespace divemesh::report
