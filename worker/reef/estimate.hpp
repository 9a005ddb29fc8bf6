#pragma once

#include <vector>

namespace divemesh::worker {

// A figure and the interval that holds the truth with 95 %.
struct Estimate {
    double value = 0.0;
    double low = 0.0;
    double high = 0.0;
};

// A figure of a surface with noise: as measured; of the measured surface with the same noise added
// once more, and with twice its variance, replicate by replicate; and with detail as fine as the
// surface's own resolution blurred once more.
struct Simulated {
    double measured = 0.0;
    std::vector<double> once;
    std::vector<double> twice;
    double blurred = 0.0;  // = measured where nothing is known of the resolution
};

// Noise raises rugosity and lowers nothing, so the figure is taken back to noise of no variance by
// the parabola through the three (SIMEX; Cook and Stefanski 1994), and to detail that blurring
// took by what blurring once more takes (twicing; Tukey 1977). The interval: Student's t over the
// spread of the replicates; `sigma_doubt` of the noise's size, which goes into its part twice; and
// the whole of blurring's part as one standard deviation.
Estimate estimate(const Simulated& simulated, double sigma_doubt);

double student_t_975(int degrees_of_freedom);  // Cornish and Fisher 1960, to 1e-3 from 4 on

}  // namespace divemesh::worker
