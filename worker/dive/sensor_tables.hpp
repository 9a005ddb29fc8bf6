#pragma once

#include <string_view>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// The data.csv of the sensors, as they stand there: in the frame of the sensor. What is wrong with
// a row or the whole is a finding. `text` is the file, `file` its name.
std::vector<types::ImuSample> parse_imu(std::string_view text,
                                        const std::string& file,
                                        FindingLog& findings);
std::vector<types::OrientationSample> parse_ahrs(std::string_view text,
                                                 const std::string& file,
                                                 FindingLog& findings);
std::vector<types::PressureSample> parse_pressure(std::string_view text,
                                                  const std::string& file,
                                                  FindingLog& findings);
types::Trajectory parse_ground_truth(std::string_view text,
                                     const std::string& file,
                                     FindingLog& findings);

}  // namespace divemesh::dive
