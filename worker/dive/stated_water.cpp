#include "worker/dive/stated_water.hpp"

#include "worker/camera/water_index.hpp"

namespace divemesh::dive {
namespace {

constexpr double kSea_c = 10.0;
constexpr double kSea_psu = 35.0;

bool is_in(const std::optional<double>& value, double min, double max) {
    return value && *value >= min && *value <= max;
}

}  // namespace

double index_of_water(const DiveInfo& info, FindingLog& findings) {
    if (is_in(info.water_temperature_c, -2.0, 40.0) && is_in(info.water_salinity_psu, 0.0, 45.0))
        return camera::water_index(*info.water_temperature_c, *info.water_salinity_psu);
    findings.warning("water_not_stated",
                     "dive.json",
                     "the cameras see through a port, but dive.json does not state the water's "
                     "temperature (-2 to 40 degrees Celsius) and salinity (0 to 45 psu): sea water "
                     "of 10 degrees is assumed, and in fresh water depths would be about 0.6 % off",
                     "Add \"water\": {\"temperature_c\": 12, \"salinity_psu\": 0} to dive.json; "
                     "0 psu is a lake, 35 psu an ocean.");
    return camera::water_index(kSea_c, kSea_psu);
}

}  // namespace divemesh::dive
