#include "worker/recording/baseline_unit.hpp"

#include "schemas/error.hpp"
#include "worker/base/text.hpp"

namespace divemesh::recording {
namespace {

// Baselines of rigs that people carry. Between both ranges a length fits neither m nor mm.
constexpr double kMinBaseline_m = 0.005;
constexpr double kMaxBaseline_m = 2.0;
constexpr double kMinBaseline_mm = 20.0;
constexpr double kMaxBaseline_mm = 2000.0;
constexpr double kMaxBaseline_cm = 200.0;

}  // namespace

double metres_per_unit(const Eigen::Vector3d& translation,
                       std::optional<double> stated,
                       const std::string& file,
                       dive::FindingLog& findings) {
    const double length = translation.norm();
    if (stated) return *stated;
    if (length >= kMinBaseline_m && length <= kMaxBaseline_m) return 1.0;
    const std::string seen = "the translation between the cameras is " + base::significant(length);
    if (!(length >= kMinBaseline_mm && length <= kMaxBaseline_mm))
        throw Error(ErrorCode::BadData,
                    file + ": " + seen +
                        " long, the baseline of no rig in m or mm: state its unit by "
                        "--calibration-unit m, cm or mm");
    if (length <= kMaxBaseline_cm)
        findings.warning("calibration_unit",
                         file,
                         seen + " long and taken as mm: a baseline of " +
                             base::significant(length * 1e-3) + " m",
                         "If it is in cm, state --calibration-unit cm.");
    else
        findings.info("calibration_unit", file, seen + " long and can only be in mm");
    return 1e-3;
}

}  // namespace divemesh::recording
