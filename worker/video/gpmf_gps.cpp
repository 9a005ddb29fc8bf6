#include "worker/video/gpmf_gps.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "worker/base/angle.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/quantile.hpp"
#include "worker/video/gpmf_klv.hpp"

namespace divemesh::video {
namespace {

constexpr double kMinLock = 2.0;  // 2D; 3 is 3D, 0 is none
constexpr double kMaxDop = 5.0;  // dilution of precision, which the format's description calls good
constexpr double kGpspPerDop = 100.0;
// Places of the numbers of a sample.
constexpr std::size_t kLatitude = 0;
constexpr std::size_t kLongitude = 1;
constexpr std::size_t kGps9Dop = 7;
constexpr std::size_t kGps9Lock = 8;
constexpr std::size_t kGps5Numbers = 5;
constexpr std::size_t kGps9Numbers = 9;
constexpr double kEarthRadius_m = 6371000.0;
constexpr double kSpreadShare = 0.95;

// What a stream states about the samples that follow.
struct GpsState {
    std::vector<double> scale;  // SCAL: divisors
    std::string types;          // TYPE: of the numbers of a sample
    double lock = 0.0;          // GPSF
    double dop = 0.0;           // GPSP
};

struct Fixes {
    std::vector<GpsFix> gps5;
    std::vector<GpsFix> gps9;
};

double divisor(const GpsState& state, std::size_t place) {
    return state.scale[state.scale.size() == 1 ? 0 : place];
}

// Appends samples that are locked and precise, which `is_good` tells.
template <typename IsGood>
void add_fixes(const std::vector<std::vector<double>>& samples,
               const GpsState& state,
               std::size_t num_numbers,
               const IsGood& is_good,
               std::vector<GpsFix>& fixes) {
    if (state.scale.size() != 1 && state.scale.size() != num_numbers) return;
    for (const auto& sample : samples) {
        const GpsFix fix{sample[kLatitude] / divisor(state, kLatitude),
                         sample[kLongitude] / divisor(state, kLongitude)};
        const types::GeographicPosition position{fix.latitude_deg, fix.longitude_deg, {}};
        if (is_good(sample) && position.is_valid()) fixes.push_back(fix);
    }
}

void add_gps5(const Klv& klv, const GpsState& state, Fixes& fixes) {
    const auto is_good = [&](const std::vector<double>&) {
        return state.lock >= kMinLock && state.dop <= kMaxDop;
    };
    const std::string types(kGps5Numbers, klv.type);
    add_fixes(samples_of(klv, types), state, kGps5Numbers, is_good, fixes.gps5);
}

void add_gps9(const Klv& klv, const GpsState& state, Fixes& fixes) {
    if (state.types.size() != kGps9Numbers) return;
    const auto is_good = [&](const std::vector<double>& sample) {
        return sample[kGps9Lock] / divisor(state, kGps9Lock) >= kMinLock &&
               sample[kGps9Dop] / divisor(state, kGps9Dop) <= kMaxDop;
    };
    add_fixes(samples_of(klv, state.types), state, kGps9Numbers, is_good, fixes.gps9);
}

void read_list(std::string_view bytes, int depth, Fixes& fixes) {
    KlvList list(bytes);
    GpsState state;
    while (const auto klv = list.next()) {
        const auto first = [&](double otherwise) {
            const auto numbers = numbers_of(*klv);
            return numbers.empty() ? otherwise : numbers.front();
        };
        if (klv->type == '\0') {
            if (depth < kMaxKlvDepth) read_list(klv->value, depth + 1, fixes);
        } else if (klv->key == "SCAL") {
            state.scale = numbers_of(*klv);
        } else if (klv->key == "TYPE") {
            state.types = klv->value.substr(0, klv->value.find('\0'));
        } else if (klv->key == "GPSF") {
            state.lock = first(0.0);
        } else if (klv->key == "GPSP") {
            state.dop = first(0.0) / kGpspPerDop;
        } else if (klv->key == "GPS5") {
            add_gps5(*klv, state, fixes);
        } else if (klv->key == "GPS9") {
            add_gps9(*klv, state, fixes);
        }
    }
}

// Returns a longitude within -180 to 180.
double wrapped_deg(double longitude_deg) { return std::remainder(longitude_deg, 360.0); }

template <typename Value>
double median_of(const std::vector<GpsFix>& fixes, const Value& value) {
    std::vector<double> values;
    values.reserve(fixes.size());
    for (const GpsFix& fix : fixes) values.push_back(value(fix));
    return stats::median(std::move(values));
}

std::vector<double> distances_m(const std::vector<GpsFix>& fixes,
                                const types::GeographicPosition& from) {
    const double east = std::cos(from.latitude_deg * base::kRadPerDeg);
    std::vector<double> distances;
    distances.reserve(fixes.size());
    for (const GpsFix& fix : fixes)
        distances.push_back(kEarthRadius_m * base::kRadPerDeg *
                            std::hypot(fix.latitude_deg - from.latitude_deg,
                                       east * wrapped_deg(fix.longitude_deg - from.longitude_deg)));
    std::sort(distances.begin(), distances.end());
    return distances;
}

}  // namespace

std::vector<GpsFix> parse_gps(std::string_view bytes) {
    Fixes fixes;
    read_list(bytes, 0, fixes);
    return fixes.gps9.empty() ? fixes.gps5 : fixes.gps9;
}

std::optional<GpsPosition> gps_position_of(const std::vector<GpmfPayload>& payloads) {
    std::vector<GpsFix> fixes;
    for (const GpmfPayload& payload : payloads) {
        const auto more = parse_gps(payload.bytes);
        fixes.insert(fixes.end(), more.begin(), more.end());
    }
    if (fixes.empty()) return std::nullopt;
    // Takes longitudes about the first one, so that those about 180 degrees have a median.
    const double about_deg = fixes.front().longitude_deg;
    const double off_deg = median_of(
        fixes, [&](const GpsFix& fix) { return wrapped_deg(fix.longitude_deg - about_deg); });
    GpsPosition found;
    found.position.latitude_deg =
        median_of(fixes, [](const GpsFix& fix) { return fix.latitude_deg; });
    found.position.longitude_deg = wrapped_deg(about_deg + off_deg);
    found.num_fixes = std::ssize(fixes);
    const auto distances = distances_m(fixes, found.position);
    found.scatter_m = stats::quantile_of_sorted(distances, 0.5);
    found.spread_m = stats::quantile_of_sorted(distances, kSpreadShare);
    return found;
}

}  // namespace divemesh::video
