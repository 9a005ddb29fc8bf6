#include "worker/report/report_inputs.hpp"

#include <array>
#include <fstream>
#include <iterator>
#include <utility>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "worker/dive/dive_json.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/recording/recorded_dive.hpp"

namespace divemesh::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kMaxMeasurements_bytes = std::uintmax_t{16} << 20;

json described(const std::string& role, const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(ErrorCode::NotFound, "cannot open " + file.string() + ": check the path");
    Sha256 hash;
    std::int64_t size_bytes = 0;
    std::vector<char> segment(std::size_t{1} << 20);
    while (stream.read(segment.data(), std::ssize(segment)) || stream.gcount() > 0) {
        const auto count = static_cast<std::size_t>(stream.gcount());
        hash.update({segment.data(), count});
        size_bytes += static_cast<std::int64_t>(count);
    }
    return {{"role", role},
            {"name", file.filename().string()},
            {"size_bytes", size_bytes},
            {"sha256", hash.hex()}};
}

json describe_files(const AccuracyReportRequest& request) {
    json files = json::array();
    const auto add = [&](const std::string& role, const fs::path& file) {
        files.push_back(described(role, file));
    };
    constexpr std::array<std::pair<const char*, const char*>, 4> kArtifacts = {
        {{"metrics", "metrics.json"},
         {"trajectory", "trajectory.tum"},
         {"trajectory_causal", "trajectory_causal.tum"},
         {"mesh", "mesh.ply"}}};
    for (const auto& [role, name] : kArtifacts)
        if (fs::exists(request.reconstruction / name)) add(role, request.reconstruction / name);
    if (request.ground_truth) add("ground_truth", *request.ground_truth);
    if (request.reference) add("reference", *request.reference);
    if (request.measurements) add("measurements", *request.measurements);
    if (request.areas) add("areas", *request.areas);
    return files;
}

std::unique_ptr<dive::Dive> open_dive(const AccuracyReportRequest& request,
                                      const io::ReconstructionFolder& reconstruction,
                                      const base::ProgressCallback& progress) {
    if (!request.dive) return nullptr;
    const base::ProgressCallback opening = [&](const Progress&) {
        progress({.stage = "evaluate", .fraction = 0.05});
    };
    auto dive = dive::Dive::open(recording::as_dive(*request.dive, request.scratch, opening),
                                 request.scratch / "dive",
                                 {},
                                 opening,
                                 request.links);
    const std::string expected =
        reconstruction.metrics().value(json::json_pointer("/dive/content_sha256"), std::string());
    if (!expected.empty() && !dive->content_hash().matches(expected))
        throw Error(ErrorCode::BadData,
                    request.dive->filename().string() +
                        " is not the dive that was reconstructed: its hash is " +
                        dive->content_sha256().substr(0, 12) + "..., but metrics.json states " +
                        expected.substr(0, 12) + "...: give the dive of this reconstruction");
    return dive;
}

}  // namespace

std::vector<dive::KnownDistance> read_known_distances(const fs::path& file,
                                                      std::vector<Finding>& findings) {
    if (fs::file_size(file) > kMaxMeasurements_bytes)
        throw Error(ErrorCode::TooLarge, file.string() + " is larger than 16 MiB");
    std::ifstream stream(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    dive::FindingLog log;
    auto distances = dive::parse_known_distances(text, log);
    for (const Finding& finding : log.all())
        if (finding.code == dive::kJsonUnreadable)
            throw Error(ErrorCode::BadData, file.filename().string() + ": " + finding.message);
    findings.insert(findings.end(), log.all().begin(), log.all().end());
    return distances;
}

ReportInputs read_report_inputs(const AccuracyReportRequest& request,
                                const base::ProgressCallback& progress) {
    ReportInputs inputs{.reconstruction = io::ReconstructionFolder(request.reconstruction)};
    inputs.files = describe_files(request);
    inputs.findings = request.findings;
    progress({.stage = "evaluate", .fraction = 0.05});
    inputs.dive = open_dive(request, inputs.reconstruction, progress);
    if (request.ground_truth) {
        inputs.truth = io::read_trajectory(*request.ground_truth);
        inputs.truth_source = request.ground_truth->filename().string();
    } else if (inputs.dive && !inputs.dive->ground_truth().empty()) {
        inputs.truth = {io::TrajectoryFormat::Euroc, inputs.dive->ground_truth()};
        inputs.truth_source = "dive";
    }
    progress({.stage = "evaluate", .fraction = 0.15});
    if (request.reference) {
        inputs.reference = io::read_mesh(*request.reference);
    } else if (inputs.dive) {
        inputs.reference = inputs.dive->read_reference_mesh();
        inputs.scene = inputs.dive->read_scene_mesh();
    }
    if (request.measurements)
        inputs.known_distances = read_known_distances(*request.measurements, inputs.findings);
    else if (inputs.dive)
        inputs.known_distances = inputs.dive->known_distances();
    progress({.stage = "evaluate", .fraction = 0.2});
    return inputs;
}

}  // namespace divemesh::report
