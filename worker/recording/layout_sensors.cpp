#include "worker/recording/layout_sensors.hpp"

#include <algorithm>
#include <optional>

#include "schemas/error.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/sensor_tables.hpp"
#include "worker/recording/time_table.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kMaxConverted_bytes = std::int64_t{32} << 20U;  // it takes some times more

const Finding* first_error(const dive::FindingLog& findings) {
    const auto& all = findings.all();
    const auto error = std::find_if(all.begin(), all.end(), [](const Finding& finding) {
        return finding.severity == Severity::Error;
    });
    return error == all.end() ? nullptr : &*error;
}

void pass_on(const dive::FindingLog& findings, dive::FindingLog& all) {
    for (const Finding& finding : findings.all()) all.add(finding);
}

// Parses a table as EuRoC writes it, or once it is converted to that.
template <typename Parse>
auto parsed(const std::string& text,
            const std::string& name,
            const Parse& parse,
            dive::FindingLog& all) {
    dive::FindingLog findings;
    auto samples = parse(text, name, findings, nullptr);
    const Finding* error = first_error(findings);
    if (error == nullptr) {
        pass_on(findings, all);
        return samples;
    }
    dive::FindingLog converted_findings;
    const auto table = std::ssize(text) <= kMaxConverted_bytes
                           ? convert_time_table(text, std::nullopt)
                           : std::nullopt;
    if (table) samples = parse(table->csv, name, converted_findings, nullptr);
    if (!table || first_error(converted_findings) != nullptr)
        throw Error(ErrorCode::BadData,
                    error->where + ": " + error->message + ": " + error->remedy);
    pass_on(converted_findings, all);
    all.info("table_converted", name, "the times in " + name + " were read as " + table->unit);
    return samples;
}

// Returns the folders below `folder` with a table that are neither cameras nor read.
std::string other_sensors(const ImageFolders& folders, const std::string& folder) {
    std::string others;
    for (const std::string& name : folders.names()) {
        if (!name.starts_with(folder) || !name.ends_with("/data.csv")) continue;
        const std::string sensor =
            name.substr(folder.size(), name.find('/', folder.size()) - folder.size());
        if (sensor.starts_with("cam") || sensor == "imu0" || sensor == "pressure0") continue;
        others += others.empty() ? "" : ", ";
        others += dive::printable(sensor);
    }
    return others;
}

}  // namespace

void add_layout_sensors(const ImageFolders& folders,
                        const std::string& folder,
                        const RigFiles& rig,
                        DiveWriter& writer,
                        dive::FindingLog& findings) {
    const std::int64_t max_bytes = dive::DiveLimits{}.max_file_bytes;
    const std::string imu = folder + "imu0/data.csv";
    const std::string pressure = folder + "pressure0/data.csv";
    if (folders.has(imu) && rig.imu_yaml)
        for (const auto& sample :
             parsed(folders.read(imu, max_bytes), imu, dive::parse_imu, findings))
            writer.add_imu(sample);
    if (folders.has(pressure))
        for (const auto& sample :
             parsed(folders.read(pressure, max_bytes), pressure, dive::parse_pressure, findings))
            writer.add_pressure(sample);
    if (const std::string others = other_sensors(folders, folder); !others.empty())
        findings.info("sensor_left_out", folder, "sensors that are not imported: " + others);
}

}  // namespace divemesh::recording
