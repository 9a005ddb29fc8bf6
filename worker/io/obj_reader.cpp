#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "worker/io/mesh_reader.hpp"

namespace divemesh::io {
namespace {

constexpr std::string_view kBlank = " \t\r";

// Splits a line into words.
class Words {
public:
    explicit Words(std::string_view line) : rest_(line) {}

    std::string_view next() {
        const auto start = rest_.find_first_not_of(kBlank);
        if (start == std::string_view::npos) return {};
        rest_.remove_prefix(start);
        const auto word = rest_.substr(0, rest_.find_first_of(kBlank));
        rest_.remove_prefix(word.size());
        return word;
    }

private:
    std::string_view rest_;
};

class ObjReader {
public:
    explicit ObjReader(const std::string& name) : name_(name) {}

    // A mesh never takes more memory than some multiple of its text: a vertex has at least six
    // bytes of it, a corner of a face two.
    types::Mesh read(std::string_view bytes) {
        while (!bytes.empty()) {
            const auto end = bytes.find('\n');
            ++line_number_;
            read_line(bytes.substr(0, end));
            bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
        }
        if (mesh_.vertices.empty()) fail("the file has no vertices");
        if (mesh_.colors.size() != mesh_.vertices.size()) mesh_.colors.clear();
        return std::move(mesh_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::BadData, name_ + ":" + std::to_string(line_number_) + ": " + what);
    }

    void read_line(std::string_view line) {
        Words words(line);
        const auto keyword = words.next();
        if (keyword == "v") read_vertex(words);
        if (keyword == "f") read_face(words);
    }

    std::optional<float> number(Words& words) const {
        const auto word = words.next();
        if (word.empty()) return std::nullopt;
        double value = 0.0;
        const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (code != std::errc() || end != word.data() + word.size() || !(std::abs(value) < 1e9))
            fail("a coordinate is not a number");
        return static_cast<float>(value);
    }

    void read_vertex(Words& words) {
        Eigen::Vector3f vertex;
        for (int axis = 0; axis < 3; ++axis) {
            const auto value = number(words);
            if (!value) fail("a vertex needs x, y and z");
            vertex[axis] = *value;
        }
        mesh_.vertices.push_back(vertex);
        types::Color color{};
        for (auto& channel : color) {
            const auto value = number(words);
            if (!value) return;  // without colours, or with w
            const float clamped = std::min(1.0F, std::max(0.0F, *value));
            channel = static_cast<std::uint8_t>(std::lround(clamped * 255.0F));
        }
        mesh_.colors.push_back(color);
    }

    // Parses "7", "7/1", "7/1/3", "7//3", or "-1" counted from the end.
    std::optional<std::uint32_t> corner(Words& words) const {
        const auto word = words.next();
        if (word.empty()) return std::nullopt;
        std::int64_t index = 0;
        const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), index);
        const auto count = std::ssize(mesh_.vertices);
        if (code != std::errc() || (end != word.data() + word.size() && *end != '/'))
            fail("a corner of a face is not a number");
        const std::int64_t place = index < 0 ? count + index : index - 1;
        if (index == 0 || place < 0 || place >= count)
            fail("a face refers to vertex " + std::to_string(index) + ", which does not exist");
        return static_cast<std::uint32_t>(place);
    }

    void read_face(Words& words) {
        const auto first = corner(words);
        auto previous = corner(words);
        auto next = corner(words);
        if (!first || !previous || !next) fail("a face needs three corners");
        for (; next; previous = next, next = corner(words))
            mesh_.triangles.push_back({*first, *previous, *next});
    }

    const std::string& name_;
    int line_number_ = 0;
    types::Mesh mesh_;
};

}  // namespace

types::Mesh parse_obj(std::string_view bytes, const std::string& name) {
    return ObjReader(name).read(bytes);
}

}  // namespace divemesh::io
