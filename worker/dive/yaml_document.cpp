#include "worker/dive/yaml_document.hpp"

#include <cmath>
#include <set>
#include <sstream>
#include <yaml-cpp/eventhandler.h>

namespace divemesh::dive {
namespace {

constexpr std::size_t kMaxDepth = 8;

// Walks through a document without building it, and stops at constructs that hostile documents use.
class Guard : public YAML::EventHandler {
public:
    explicit Guard(int max_nodes) : max_nodes_(max_nodes) {}
    void OnDocumentStart(const YAML::Mark&) override {}
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { node(mark, anchor); }
    void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
        throw YAML::ParserException(mark, "aliases are not allowed here");
    }
    void OnScalar(const YAML::Mark& mark,
                  const std::string&,
                  YAML::anchor_t anchor,
                  const std::string& value) override {
        const bool is_key = !levels_.empty() && levels_.back().at_key;
        if (is_key && !levels_.back().keys.insert(value).second)
            throw YAML::ParserException(mark, "\"" + value + "\" is stated twice");
        node(mark, anchor);
    }
    void OnSequenceStart(const YAML::Mark& mark,
                         const std::string&,
                         YAML::anchor_t anchor,
                         YAML::EmitterStyle::value) override {
        open(mark, anchor, false);
    }
    void OnSequenceEnd() override { levels_.pop_back(); }
    void OnMapStart(const YAML::Mark& mark,
                    const std::string&,
                    YAML::anchor_t anchor,
                    YAML::EmitterStyle::value) override {
        open(mark, anchor, true);
    }
    void OnMapEnd() override { levels_.pop_back(); }

private:
    void node(const YAML::Mark& mark, YAML::anchor_t anchor) {
        if (anchor != 0) throw YAML::ParserException(mark, "anchors are not allowed here");
        if (++num_nodes_ > max_nodes_) throw YAML::ParserException(mark, "too many values");
        if (!levels_.empty() && levels_.back().is_map)
            levels_.back().at_key = !levels_.back().at_key;
    }
    void open(const YAML::Mark& mark, YAML::anchor_t anchor, bool is_map) {
        node(mark, anchor);
        if (levels_.size() >= kMaxDepth) throw YAML::ParserException(mark, "nested too deep");
        levels_.push_back({is_map, is_map, {}});
    }

    struct Level {
        bool is_map;
        bool at_key;  // the next node in a map is a key
        std::set<std::string> keys;
    };
    std::vector<Level> levels_;
    int max_nodes_;
    int num_nodes_ = 0;
};

// Removes the %YAML line, as OpenCV's files have one that is not valid YAML; EuRoC's have none.
std::string without_directive(std::string_view text) {
    if (!text.starts_with("%YAML")) return std::string(text);
    std::string result(text);
    for (char& c : result) {
        if (c == '\n') break;
        c = ' ';
    }
    return result;
}

// Appends a list of numbers, or of nested lists, as one list.
void append_numbers(const YAML::Node& node, std::vector<double>& numbers) {
    if (!node.IsSequence()) {
        numbers.push_back(number(node));
        return;
    }
    for (const auto& item : node) append_numbers(item, numbers);
}

}  // namespace

YAML::Node load_yaml(std::string_view text, int max_nodes) {
    const std::string document = without_directive(text);
    std::istringstream stream(document);
    YAML::Parser parser(stream);
    Guard guard(max_nodes);
    if (!parser.HandleNextDocument(guard)) return {};
    return YAML::Load(document);
}

double number(const YAML::Node& node) {
    const auto value = node.as<double>();
    if (!std::isfinite(value)) throw YAML::ParserException(node.Mark(), "not a finite number");
    return value;
}

std::vector<double> numbers_at(const YAML::Node& root, const std::string& key) {
    std::vector<double> numbers;
    const YAML::Node node = root[key];
    if (!node || node.IsNull()) return numbers;
    if (node.IsMap() && !node["data"]) throw YAML::ParserException(node.Mark(), "it has no data");
    append_numbers(node.IsMap() ? node["data"] : node, numbers);
    return numbers;
}

std::optional<double> number_at(const YAML::Node& root, const std::string& key) {
    const YAML::Node node = root[key];
    if (!node || node.IsNull()) return std::nullopt;
    return number(node);
}

std::string text_at(const YAML::Node& root, const std::string& key) {
    const YAML::Node node = root[key];
    return node && node.IsScalar() ? node.Scalar() : "";
}

std::optional<Eigen::Matrix4d> matrix_at(const YAML::Node& root, const std::string& key) {
    const YAML::Node node = root[key];
    if (!node || node.IsNull()) return std::nullopt;
    std::vector<double> numbers = numbers_at(root, key);
    if (numbers.size() == 12) numbers.insert(numbers.end(), {0.0, 0.0, 0.0, 1.0});
    if (numbers.size() != 16)
        throw YAML::ParserException(
            node.Mark(), key + " has " + std::to_string(numbers.size()) + " numbers, not 16");
    return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
}

}  // namespace divemesh::dive
