#include "schemas/sensor_message.hpp"

#include <algorithm>

#include "schemas/invalid_input.hpp"
#include "schemas/sensor_status.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

// Doubles hold whole numbers up to here, and so does every client's JSON.
constexpr std::int64_t kLargestNumber = std::int64_t{1} << 53;

std::string at_most(std::string_view what, std::size_t number) {
    return std::string(what).append(", ").append(std::to_string(number)).append(" at most");
}

// 1 to 64 letters, digits, '.', '_' and '-'.
bool is_boot_id(std::string_view id) {
    constexpr std::string_view kMore = "._-";
    return !id.empty() && id.size() <= 64 && std::all_of(id.begin(), id.end(), [&](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               kMore.find(c) != std::string_view::npos;
    });
}

class Reader {
public:
    SensorReport read(const json& body) {
        if (!body.is_object()) refuse("a report has to be a JSON object", "");
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
        constexpr std::size_t kMostFaults = 20;
        if (faults_.size() < kMostFaults) faults_.push_back({what, pointer, ""});
    }

    void read_boot(const json& body) {
        const auto boot = body.find("boot_id");
        if (boot == body.end() || !boot->is_string() || !is_boot_id(boot->get<std::string>()))
            return fail(
                "\"boot_id\" has to be 1 to 64 letters, digits, '.', '_' or '-', new at each boot",
                "/boot_id");
        report_.boot_id = boot->get<std::string>();
    }

    void read_messages(const json& body) {
        const auto messages = body.find("messages");
        if (messages == body.end() || !messages->is_array() || messages->size() > kMostMessages)
            return fail(at_most("\"messages\" has to be an array of messages", kMostMessages),
                        "/messages");
        for (std::size_t i = 0; i < messages->size(); ++i)
            read_message((*messages)[i], "/messages/" + std::to_string(i));
    }

    void read_message(const json& message, const std::string& pointer) {
        if (!message.is_object()) return fail("a message has to be an object", pointer);
        SensorMessage read;
        read.sequence = count(message, "seq", pointer).value_or(-1);
        read.uptime_ms = count(message, "uptime_ms", pointer).value_or(-1);
        if (message.contains("time_ms")) read.time_ms = count(message, "time_ms", pointer);
        const auto historical = message.find("historical");
        if (historical != message.end()) {
            if (!historical->is_boolean())
                fail("\"historical\" has to be true or false", pointer + "/historical");
            else
                read.historical = historical->get<bool>();
        }
        const bool says_hello = message.contains("hello");
        if (says_hello == message.contains("status"))
            return fail("a message has either \"hello\" or \"status\"", pointer);
        read.kind = says_hello ? MessageKind::Hello : MessageKind::Status;
        read.body = message.at(says_hello ? "hello" : "status");
        const std::string place = pointer + (says_hello ? "/hello" : "/status");
        if (!read.body.is_object()) return fail("it has to be an object", place);
        if (read.body.dump(-1, ' ', false, json::error_handler_t::replace).size() >
            kMostMessageBytes)
            return fail(at_most("it is too long, of bytes", kMostMessageBytes), place);
        check_body(read, place);
        report_.messages.push_back(std::move(read));
    }

    void check_body(const SensorMessage& message, const std::string& place) {
        try {
            if (message.kind == MessageKind::Status) check_status(message.body, place);
        } catch (const InvalidInput& invalid) {
            for (const Fault& fault : invalid.faults()) fail(fault.detail, fault.pointer);
        }
        if (message.kind != MessageKind::Hello) return;
        const auto texts = message.body.find("capabilities");
        if (texts == message.body.end()) return;
        const auto is_text = [](const json& word) { return word.is_string(); };
        if (!texts->is_array() || !std::all_of(texts->begin(), texts->end(), is_text))
            fail("\"capabilities\" has to be an array of words", place + "/capabilities");
    }

    std::optional<std::int64_t> count(const json& message,
                                      const char* name,
                                      const std::string& pointer) {
        const auto value = message.find(name);
        if (value != message.end() && value->is_number_integer()) {
            const auto number = value->get<std::int64_t>();
            const bool is_huge =
                value->is_number_unsigned() &&
                value->get<std::uint64_t>() > static_cast<std::uint64_t>(kLargestNumber);
            if (!is_huge && number >= 0 && number <= kLargestNumber) return number;
        }
        std::string detail(1, '"');
        fail(detail.append(name).append("\" has to be a whole number from 0 to 2^53"),
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
                    end.get<std::uint64_t>() > static_cast<std::uint64_t>(kLargestNumber))
                    return false;
            return range[0].get<std::int64_t>() <= range[1].get<std::int64_t>();
        };
        if (!lost->is_array() || lost->size() > kMostLost ||
            !std::all_of(lost->begin(), lost->end(), is_range))
            return fail(at_most("\"lost\" has to be an array of pairs [first, last]", kMostLost),
                        "/lost");
        for (const json& range : *lost)
            report_.lost.push_back({range[0].get<std::int64_t>(), range[1].get<std::int64_t>()});
    }

    SensorReport report_;
    std::vector<Fault> faults_;
};

}  // namespace

SensorReport sensor_report(const json& body) { return Reader().read(body); }

}  // namespace divemesh
