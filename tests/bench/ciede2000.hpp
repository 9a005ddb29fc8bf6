#pragma once

#include <array>

namespace divemesh::bench {

// A colour in CIE L* a* b*.
struct Lab {
    double l = 0.0;
    double a = 0.0;
    double b = 0.0;
};

// Returns the colour of linear light with the primaries of sRGB (IEC 61966-2-1), white D65.
Lab lab_of(const std::array<double, 3>& linear_rgb);

// Returns the difference of two colours, CIE dE 2000 (Sharma, Wu and Dalal, "The CIEDE2000
// color-difference formula: implementation notes, supplementary test data, and mathematical
// observations", 2005).
double ciede2000(const Lab& one, const Lab& other);

}  // namespace divemesh::bench
