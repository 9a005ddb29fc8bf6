#include "cli/imported_text.hpp"

#include <sstream>

#include "cli/findings_text.hpp"
#include "schemas/json.hpp"

namespace divemesh::cli {

nlohmann::json imported_json(const recording::ImportCounts& counts,
                             const std::vector<Finding>& findings) {
    return {{"findings", findings},
            {"num_left", counts.num_left},
            {"num_right", counts.num_right},
            {"num_imu", counts.num_imu},
            {"num_pressures", counts.num_pressures}};
}

std::string imported_text(const recording::ImportCounts& counts,
                          const std::vector<Finding>& findings,
                          const std::filesystem::path& out,
                          const std::string& cameras) {
    std::ostringstream text;
    for (const Finding& finding : findings) text << finding_text(finding);
    text << out.string() << ": " << counts.num_left << " left and " << counts.num_right
         << " right images";
    if (!cameras.empty()) text << " (" << cameras << ')';
    text << ", " << counts.num_imu << " IMU rows, " << counts.num_pressures << " depths\n";
    return text.str();
}

}  // namespace divemesh::cli
