#include "schemas/sensor_message.hpp"

#include <algorithm>

#include "schemas/base64.hpp"
#include "schemas/enum_text.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/jpeg_header.hpp"
#include "schemas/sensor_command.hpp"
#include "schemas/sensor_status.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

// Doubles, and so the JSON of every client, hold integers up to here.
constexpr std::int64_t kMaxNumber = std::int64_t{1} << 53;
constexpr std::size_t kMaxCameraLetters = 16;

constexpr EnumText<MessageKind> kKinds[] = {{MessageKind::Hello, "hello"},
                                            {MessageKind::Status, "status"},
                                            {MessageKind::Preview, "preview"},
                                            {MessageKind::Outcome, "outcome"}};

std::string at_most(std::string_view what, std::size_t number) {
    return std::string(what).append(": at most ").append(std::to_string(number));
}

// Returns whether a name has 1 to kMaxCameraLetters of a-z, 0-9, '_' and '-'.
bool is_camera(std::string_view name) {
    return !name.empty() && name.size() <= kMaxCameraLetters &&
           std::all_of(name.begin(), name.end(), [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
           });
}

bool is_boot_id(std::string_view id) {
    constexpr std::string_view kMore = "._-";
    return !id.empty() && id.size() <= 64 && std::all_of(id.begin(), id.end(), [&](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               kMore.find(c) != std::string_view::npos;
    });
}

// Returns the message's only kind; nullopt if it has none or several.
std::optional<EnumText<MessageKind>> kind_of(const json& message) {
    std::optional<EnumText<MessageKind>> kind;
    for (const auto& row : kKinds) {
        if (!message.contains(row.text)) continue;
        if (kind) return std::nullopt;
        kind = row;
    }
    return kind;
}

class Reader {
public:
    // `jpeg`: the preview's bytes, if they do not come as base64.
    explicit Reader(std::optional<std::string_view> jpeg = std::nullopt) : jpeg_(jpeg) {}

    SensorReport read(const json& body) {
        if (!body.is_object()) refuse("a report must be a JSON object", "");
        for (const auto& [key, value] : body.items())
            if (key != "boot_id" && key != "messages" && key != "lost")
                fail(std::string("unknown key ").append(key),
                     (json::json_pointer() / key).to_string());
        read_boot(body);
        read_messages(body);
        read_lost(body);
        if (!faults_.empty()) throw InvalidInput(std::move(faults_));
        return std::move(report_);
    }

private:
    [[noreturn]] void refuse(const std::string& what, const std::string& pointer) {
        fail(what, pointer);
        throw InvalidInput(std::move(faults_));
    }
    void fail(const std::string& what, const std::string& pointer) {
        constexpr std::size_t kMaxReportedFaults = 20;
        if (faults_.size() < kMaxReportedFaults) faults_.push_back({what, pointer, ""});
    }

    void read_boot(const json& body) {
        const auto boot = body.find("boot_id");
        if (boot == body.end() || !boot->is_string() || !is_boot_id(boot->get<std::string>()))
            return fail(
                "\"boot_id\" must be 1 to 64 letters, digits, '.', '_' or '-', and new at each "
                "boot",
                "/boot_id");
        report_.boot_id = boot->get<std::string>();
    }

    void read_messages(const json& body) {
        const auto messages = body.find("messages");
        if (messages == body.end() || !messages->is_array() || messages->size() > kMaxMessages)
            return fail(at_most("\"messages\" must be an array of messages", kMaxMessages),
                        "/messages");
        for (std::size_t i = 0; i < messages->size(); ++i)
            read_message((*messages)[i], "/messages/" + std::to_string(i));
    }

    void read_message(const json& message, const std::string& pointer) {
        if (!message.is_object()) return fail("a message must be an object", pointer);
        SensorMessage read;
        read.sequence = count(message, "seq", pointer).value_or(-1);
        read.uptime_ms = count(message, "uptime_ms", pointer).value_or(-1);
        if (message.contains("time_ms")) read.time_ms = count(message, "time_ms", pointer);
        const auto historical = message.find("historical");
        if (historical != message.end()) {
            if (!historical->is_boolean())
                fail("\"historical\" must be true or false", pointer + "/historical");
            else
                read.historical = historical->get<bool>();
        }
        const auto kind = kind_of(message);
        if (!kind)
            return fail(
                "a message must have exactly one of \"hello\", \"status\", \"preview\" and "
                "\"outcome\"",
                pointer);
        read.kind = kind->value;
        read.body = message.at(kind->text);
        const std::string place = std::string(pointer).append("/").append(kind->text);
        if (!read.body.is_object()) return fail("it must be an object", place);
        if (read.kind == MessageKind::Preview) take_image(read, place);
        if (read.body.dump(-1, ' ', false, json::error_handler_t::replace).size() >
            kMaxSensorMessageBytes)
            return fail(at_most("it has too many bytes", kMaxSensorMessageBytes), place);
        check_body(read, place);
        report_.messages.push_back(std::move(read));
    }

    void check_body(const SensorMessage& message, const std::string& place) {
        try {
            // A preview reports the device's condition in the fields of a status.
            if (message.kind == MessageKind::Status || message.kind == MessageKind::Preview)
                check_status(message.body, place);
            if (message.kind == MessageKind::Outcome) check_outcome(message.body, place);
        } catch (const InvalidInput& invalid) {
            for (const Fault& fault : invalid.faults()) fail(fault.detail, fault.pointer);
        }
        if (message.kind != MessageKind::Hello) return;
        const auto texts = message.body.find("capabilities");
        if (texts == message.body.end()) return;
        const auto is_text = [](const json& word) { return word.is_string(); };
        if (!texts->is_array() || !std::all_of(texts->begin(), texts->end(), is_text))
            fail("\"capabilities\" must be an array of words", place + "/capabilities");
    }

    void take_image(SensorMessage& message, const std::string& place) {
        const auto camera = message.body.find("camera");
        if (camera == message.body.end() || !camera->is_string() ||
            !is_camera(camera->get_ref<const std::string&>()))
            fail("\"camera\" must be 1 to 16 characters of a-z 0-9 _ -", place + "/camera");
        if (jpeg_) {
            message.jpeg = *jpeg_;
        } else if (!decode_image_base64(message)) {
            return fail("\"jpeg\" must be the image in base64", place + "/jpeg");
        }
        message.body.erase("jpeg");
        if (message.jpeg.size() > kMaxJpegBytes)
            return fail(at_most("the image has too many bytes", kMaxJpegBytes), place + "/jpeg");
        try {
            const JpegSize size = read_jpeg_size(message.jpeg);
            if (size.width > kMaxImageSide || size.height > kMaxImageSide)
                return fail(at_most("the image has too many pixels per side", kMaxImageSide),
                            place + "/jpeg");
            message.body["width"] = size.width;
            message.body["height"] = size.height;
        } catch (const Error& error) {
            fail(error.what(), place + "/jpeg");
        }
    }

    static bool decode_image_base64(SensorMessage& message) {
        const auto text = message.body.find("jpeg");
        if (text == message.body.end() || !text->is_string()) return false;
        auto jpeg = decode_base64(text->get_ref<const std::string&>());
        if (jpeg) message.jpeg = std::move(*jpeg);
        return jpeg.has_value();
    }

    std::optional<std::int64_t> count(const json& message,
                                      const char* name,
                                      const std::string& pointer) {
        const auto value = message.find(name);
        if (value != message.end() && value->is_number_integer()) {
            const auto number = value->get<std::int64_t>();
            const bool is_huge =
                value->is_number_unsigned() &&
                value->get<std::uint64_t>() > static_cast<std::uint64_t>(kMaxNumber);
            if (!is_huge && number >= 0 && number <= kMaxNumber) return number;
        }
        std::string detail(1, '"');
        fail(detail.append(name).append("\" must be a whole number from 0 to 2^53"),
             std::string(pointer).append("/").append(name));
        return std::nullopt;
    }

    void read_lost(const json& body) {
        const auto lost = body.find("lost");
        if (lost == body.end()) return;
        const auto is_range = [](const json& range) {
            if (!range.is_array() || range.size() != 2) return false;
            for (const json& end : range)
                if (!end.is_number_unsigned() ||
                    end.get<std::uint64_t>() > static_cast<std::uint64_t>(kMaxNumber))
                    return false;
            return range[0].get<std::int64_t>() <= range[1].get<std::int64_t>();
        };
        if (!lost->is_array() || lost->size() > kMaxLost ||
            !std::all_of(lost->begin(), lost->end(), is_range))
            return fail(at_most("\"lost\" must be an array of pairs [first, last]", kMaxLost),
                        "/lost");
        for (const json& range : *lost)
            report_.lost.push_back({range[0].get<std::int64_t>(), range[1].get<std::int64_t>()});
    }

    std::optional<std::string_view> jpeg_;
    SensorReport report_;
    std::vector<Fault> faults_;
};

}  // namespace

std::string_view to_string(MessageKind kind) { return enum_to_text(kKinds, kind); }

SensorReport sensor_report(const json& body) { return Reader().read(body); }

PreviewFrame split_preview(std::string_view frame) {
    constexpr std::size_t kLengthBytes = 4;
    std::size_t length = 0;
    for (std::size_t i = 0; i < kLengthBytes && i < frame.size(); ++i)
        length = length << 8 | static_cast<unsigned char>(frame[i]);
    if (frame.size() < kLengthBytes || length > frame.size() - kLengthBytes)
        throw Error(ErrorCode::InvalidArgument,
                    "a binary frame must be the length of a header (4 bytes, big endian), the "
                    "header in JSON, and a JPEG");
    return {frame.substr(kLengthBytes, length), frame.substr(kLengthBytes + length)};
}

SensorReport sensor_preview(json header, std::string_view jpeg) {
    if (!header.is_object() || !header.contains("preview"))
        throw InvalidInput({{"the header of a preview must have \"preview\"", "/preview", ""}});
    json body = {{"messages", json::array()}};
    if (const auto boot = header.find("boot_id"); boot != header.end()) {
        body["boot_id"] = *boot;
        header.erase(boot);
    }
    body["messages"].push_back(std::move(header));
    return Reader(jpeg).read(body);
}

}  // namespace divemesh
