#include "worker/pipeline/georeference_metrics.hpp"

namespace divemesh::pipeline {
namespace {

using nlohmann::json;

json to_metrics(const types::SourceAgreement& source) {
    json result = {{"name", source.name},
                   {"kind", source.kind},
                   {"num_rows", source.num_rows},
                   {"num_without_path", source.num_without_path},
                   {"num_used", source.num_used()},
                   {"num_rejected", source.num_rejected},
                   {"rms_m", source.rms_m},
                   {"sigma_factor", source.sigma_factor},
                   {"correlation_factor", source.correlation_factor}};
    if (source.epsg != 0) result["epsg"] = source.epsg;
    if (!source.left_out.empty()) result["left_out"] = source.left_out;
    return result;
}

}  // namespace

json to_metrics(const types::GeoReference& georeference) {
    json sources = json::array();
    for (const types::SourceAgreement& source : georeference.sources)
        sources.push_back(to_metrics(source));
    json result = {{"sources", std::move(sources)},
                   {"path_joined", georeference.path_joined},
                   {"path_sigma_factor", georeference.path_sigma_factor},
                   {"largest_correction_m", georeference.largest_correction_m},
                   {"num_joined_segments", georeference.num_joined_segments}};
    if (georeference.num_joined_segments > 0)
        result["joined_sigma_m"] = georeference.joined_sigma_m;
    if (!georeference.position) return result;
    const Eigen::Vector3d& place_m = georeference.utm_m;
    const Eigen::Vector3d& sigma_m = georeference.sigma_m;
    result["epsg"] = georeference.utm_epsg;
    result["easting_m"] = place_m.x();
    result["northing_m"] = place_m.y();
    result["easting_sigma_m"] = sigma_m.x();
    result["northing_sigma_m"] = sigma_m.y();
    if (georeference.has_height) {
        result["up_m"] = place_m.z();
        result["up_sigma_m"] = sigma_m.z();
    }
    result["heading_sigma_deg"] = georeference.heading_sigma_deg;
    if (georeference.position->x_azimuth_deg)
        result["x_azimuth_deg"] = *georeference.position->x_azimuth_deg;
    return result;
}

}  // namespace divemesh::pipeline
