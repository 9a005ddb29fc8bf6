#pragma once

#include <string_view>
#include <vector>

#include "worker/dive/common_clock.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Parse the data.csv files of the sensors; samples stay in the frame of the sensor. Problems of a
// row or of the whole file are findings. Samples are in the order of time; where the clock was set
// back they are moved, as far as it is known with the shifts of `clock`, to which the table is
// added. `text` is the file's contents, `file` its name.
std::vector<types::ImuSample> parse_imu(std::string_view text,
                                        const std::string& file,
                                        FindingLog& findings,
                                        CommonClock* clock = nullptr);
std::vector<types::OrientationSample> parse_ahrs(std::string_view text,
                                                 const std::string& file,
                                                 FindingLog& findings,
                                                 CommonClock* clock = nullptr);
std::vector<types::PressureSample> parse_pressure(std::string_view text,
                                                  const std::string& file,
                                                  FindingLog& findings,
                                                  CommonClock* clock = nullptr);
types::Trajectory parse_ground_truth(std::string_view text,
                                     const std::string& file,
                                     FindingLog& findings,
                                     CommonClock* clock = nullptr);

}  // namespace divemesh::dive
