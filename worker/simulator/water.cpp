#include "worker/simulator/water.hpp"

#include "schemas/error.hpp"

namespace divemesh::simulator {

Water make_water(WaterKind kind) {
    Water water;
    water.is_water = kind != WaterKind::None;
    switch (kind) {
        case WaterKind::None:
            water.ambient = {0.55F, 0.55F, 0.56F};
            water.sun = {0.65F, 0.62F, 0.56F};
            return water;
        case WaterKind::Clear:
            water.attenuation_per_m = {0.42F, 0.13F, 0.11F};
            water.backscatter_per_m = {0.30F, 0.14F, 0.13F};
            water.veil = {0.02F, 0.17F, 0.28F};
            water.ambient = {0.20F, 0.42F, 0.48F};
            water.sun = {0.34F, 0.75F, 0.82F};
            water.strobe = {0.42F, 0.36F, 0.32F};
            water.exposure = 1.4F;
            return water;
        case WaterKind::Green:
            water.attenuation_per_m = {0.55F, 0.27F, 0.32F};
            water.backscatter_per_m = {0.40F, 0.26F, 0.29F};
            water.veil = {0.02F, 0.13F, 0.12F};
            water.ambient = {0.17F, 0.42F, 0.36F};
            water.sun = {0.26F, 0.72F, 0.62F};
            water.strobe = {0.50F, 0.42F, 0.36F};
            water.exposure = 1.7F;
            return water;
        case WaterKind::Turbid:
            water.attenuation_per_m = {1.00F, 0.72F, 0.85F};
            water.backscatter_per_m = {0.80F, 0.70F, 0.78F};
            water.veil = {0.05F, 0.14F, 0.09F};
            water.ambient = {0.22F, 0.44F, 0.30F};
            water.sun = {0.12F, 0.24F, 0.17F};
            water.strobe = {0.55F, 0.48F, 0.40F};
            water.exposure = 1.7F;
            return water;
    }
    throw Error(ErrorCode::InvalidArgument, "unknown water");
}

}  // namespace divemesh::simulator
