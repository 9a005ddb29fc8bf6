#pragma once

#include <vector>

#include "worker/dive/epipolar_samples.hpp"

namespace divemesh::dive {

// Replaces the rates of a moment's samples by those of the camera's motion: a robust least-squares
// fit over all samples of what rotation and translation make of a rate, which is linear in products
// of ray and inverse depth (Longuet-Higgins and Prazdny 1980). The noise of single rates would make
// a delay that is fitted by them too small (regression dilution). Too few samples stay as they are.
void smooth_rates(std::vector<EpipolarSample>& samples);

}  // namespace divemesh::dive
