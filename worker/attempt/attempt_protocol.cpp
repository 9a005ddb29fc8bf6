#include "worker/attempt/attempt_protocol.hpp"

#include "schemas/json.hpp"

namespace divemesh::attempt {
namespace {

using nlohmann::json;

json message_body(const Progress& progress) { return {{"type", "progress"}, {"body", progress}}; }

json message_body(const LogText& log) { return {{"type", "log"}, {"body", log.text}}; }

json message_body(const StageRun& stage) { return {{"type", "stage"}, {"body", stage}}; }

json message_body(const Measurement& measured) {
    return {{"type", "measured"}, {"body", measured}};
}

json message_body(const UnreadableTruth& truth) {
    return {{"type", "unreadable_truth"},
            {"body", {{"kind", to_string(truth.kind)}, {"problem", truth.problem}}}};
}

json message_body(const Done&) { return {{"type", "done"}, {"body", nullptr}}; }

json message_body(const Failure& failure) { return {{"type", "failed"}, {"body", failure}}; }

json message_body(const IntakeAnswer& answer) {
    return {{"type", "intake"},
            {"body",
             {{"findings", answer.findings},
              {"name", answer.name},
              {"site", answer.site},
              {"rig", answer.rig},
              {"tags", answer.tags},
              {"notes", answer.notes},
              {"position", answer.position ? json(*answer.position) : json()},
              {"content_sha256", answer.content_sha256.sha256},
              {"with_desktop_files", answer.content_sha256.with_desktop_files},
              {"num_frames", answer.num_frames},
              {"duration_s", answer.duration_s},
              {"has_thumbnail", answer.has_thumbnail}}}};
}

IntakeAnswer intake_from_json(const json& body) {
    IntakeAnswer answer;
    body.at("findings").get_to(answer.findings);
    body.at("name").get_to(answer.name);
    body.at("site").get_to(answer.site);
    body.at("rig").get_to(answer.rig);
    body.at("tags").get_to(answer.tags);
    body.at("notes").get_to(answer.notes);
    if (const json& position = body.at("position"); !position.is_null())
        answer.position = position.get<DivePosition>();
    body.at("content_sha256").get_to(answer.content_sha256.sha256);
    body.at("with_desktop_files").get_to(answer.content_sha256.with_desktop_files);
    body.at("num_frames").get_to(answer.num_frames);
    body.at("duration_s").get_to(answer.duration_s);
    body.at("has_thumbnail").get_to(answer.has_thumbnail);
    return answer;
}

}  // namespace

void to_json(json& out, const AttemptRequest& request) {
    out = {{"kind", to_string(request.kind)},
           {"dive", request.dive.string()},
           {"out", request.out.string()},
           {"scratch", request.scratch.string()},
           {"cache", request.cache.string()},
           {"cache_bytes", request.cache_bytes},
           {"preset", request.preset},
           {"options", request.options},
           {"reconstructions", json::array()},
           {"truth", json::object()},
           {"history", request.history},
           {"findings", request.findings}};
    for (const auto& folder : request.reconstructions)
        out["reconstructions"].push_back(folder.string());
    for (const auto& [option, file] : request.truth) out["truth"][option] = file.string();
}

void from_json(const json& in, AttemptRequest& request) {
    request.kind = job_kind_from_string(in.at("kind").get<std::string>());
    request.dive = in.at("dive").get<std::string>();
    request.out = in.at("out").get<std::string>();
    request.scratch = in.at("scratch").get<std::string>();
    request.cache = in.at("cache").get<std::string>();
    in.at("cache_bytes").get_to(request.cache_bytes);
    in.at("preset").get_to(request.preset);
    request.options = in.at("options");
    for (const json& folder : in.at("reconstructions"))
        request.reconstructions.emplace_back(folder.get<std::string>());
    for (const auto& [option, file] : in.at("truth").items())
        request.truth[option] = file.get<std::string>();
    in.at("history").get_to(request.history);
    in.at("findings").get_to(request.findings);
}

std::string encode_message(const AttemptMessage& message) {
    const json line = std::visit([](const auto& value) { return message_body(value); }, message);
    // Text of a recording may contain any bytes: invalid UTF-8 is replaced instead of throwing.
    return line.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

AttemptMessage decode_message(const std::string& line) {
    try {
        const json message = json::parse(line);
        const auto type = message.at("type").get<std::string>();
        const json& body = message.at("body");
        if (type == "progress") return body.get<Progress>();
        if (type == "log") return LogText{body.get<std::string>()};
        if (type == "stage") return body.get<StageRun>();
        if (type == "intake") return intake_from_json(body);
        if (type == "measured") return body.get<Measurement>();
        if (type == "unreadable_truth")
            return UnreadableTruth{truth_kind_from_string(body.at("kind").get<std::string>()),
                                   body.at("problem").get<std::string>()};
        if (type == "done") return Done{};
        if (type == "failed") return body.get<Failure>();
        throw Error(ErrorCode::BadData, "an attempt sent an unknown message: " + type);
    } catch (const json::exception& error) {
        throw Error(ErrorCode::BadData,
                    std::string("an attempt sent a malformed message: ") + error.what());
    }
}

}  // namespace divemesh::attempt
