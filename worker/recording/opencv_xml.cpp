#include "worker/recording/opencv_xml.hpp"

#include <algorithm>
#include <set>
#include <string>

namespace divemesh::recording {
namespace {

constexpr int kMaxDepth = 8;
constexpr int kMaxElements = 1000;
constexpr int kMaxWords = 100000;
constexpr std::string_view kBlanks = " \t\r\n";

class OpenCvXml {
public:
    explicit OpenCvXml(std::string_view text) : all_(text), rest_(text) {}

    YAML::Node document() {
        skip_remarks();
        const std::string name = open_tag();
        if (name != "opencv_storage") fail("it does not begin with <opencv_storage>");
        return content(name, 1);
    }

private:
    [[noreturn]] void fail(const char* what) const {
        const auto consumed = all_.substr(0, all_.size() - rest_.size());
        YAML::Mark mark;
        mark.line = static_cast<int>(std::count(consumed.begin(), consumed.end(), '\n'));
        throw YAML::ParserException(mark, what);
    }

    void skip_blanks() {
        rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
    }
    void skip_past(std::string_view end) {
        const std::size_t at = rest_.find(end);
        if (at == std::string_view::npos) fail("it ends within a remark or a tag");
        rest_.remove_prefix(at + end.size());
    }
    // Skips <?xml ...?> and comments.
    void skip_remarks() {
        for (skip_blanks();; skip_blanks()) {
            if (rest_.starts_with("<?"))
                skip_past("?>");
            else if (rest_.starts_with("<!--"))
                skip_past("-->");
            else
                return;
        }
    }

    // Returns the name of the tag that begins here and skips its attributes.
    std::string open_tag() {
        if (!rest_.starts_with('<')) fail("a tag is missing");
        if (++num_elements_ > kMaxElements) fail("too many elements");
        rest_.remove_prefix(1);
        const std::size_t length = std::min(rest_.find_first_of(" \t\r\n/>"), rest_.size());
        std::string name(rest_.substr(0, length));
        const std::size_t end = rest_.find('>');
        if (name.empty() || end == std::string_view::npos || rest_.substr(0, end).ends_with('/'))
            fail("a tag has no name or no content");
        rest_.remove_prefix(end + 1);
        return name;
    }

    // Returns what stands before </name> and skips that.
    YAML::Node content(const std::string& name, int depth) {
        if (depth > kMaxDepth) fail("nested too deep");
        YAML::Node node = words();
        std::set<std::string> names;
        for (skip_remarks(); !rest_.starts_with("</"); skip_remarks()) {
            const std::string child = open_tag();
            const YAML::Node value = content(child, depth + 1);
            if (child == "_") continue;  // an item of a list, of which calibrations need none
            if (!names.insert(child).second) fail("an element is stated twice");
            if (!node.IsMap()) node = YAML::Node(YAML::NodeType::Map);
            node[child] = value;
        }
        if (!rest_.starts_with("</" + name)) fail("a tag is closed that is not open");
        skip_past(">");
        return node;
    }

    YAML::Node words() {
        const auto text = rest_.substr(0, std::min(rest_.find('<'), rest_.size()));
        YAML::Node list(YAML::NodeType::Sequence);
        std::size_t at = text.find_first_not_of(kBlanks);
        while (at != std::string_view::npos) {
            if (++num_words_ > kMaxWords) fail("too many values");
            const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
            list.push_back(std::string(text.substr(at, end - at)));
            at = text.find_first_not_of(kBlanks, end);
        }
        rest_.remove_prefix(text.size());
        return list.size() == 1 ? YAML::Node(list[0].Scalar()) : list;
    }

    std::string_view all_;
    std::string_view rest_;
    int num_elements_ = 0;
    int num_words_ = 0;
};

}  // namespace

YAML::Node parse_opencv_xml(std::string_view text) { return OpenCvXml(text).document(); }

}  // namespace divemesh::recording
