#include "storage/xml_tree.hpp"

#include <expat.h>
#include <limits>
#include <memory>

#include "schemas/error.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxDepth = 16;
constexpr std::size_t kMaxElements = 50'000;

// Builds the tree while the parser reads. No exception may pass through the parser, which is C.
class Builder {
public:
    explicit Builder(XML_Parser parser) : parser_(parser) {
        XML_SetUserData(parser, this);
        XML_SetElementHandler(parser, on_start, on_end);
        XML_SetCharacterDataHandler(parser, on_text);
        XML_SetStartDoctypeDeclHandler(parser, on_doctype);
    }

    XmlNode take_root() {
        if (root_.children.size() != 1) throw_unreadable("it has no element");
        return std::move(root_.children.front());
    }
    [[noreturn]] static void throw_unreadable(const std::string& why) {
        throw Error(ErrorCode::Unavailable, "the answer is no XML that can be read: " + why);
    }

private:
    static void on_start(void* self, const char* name, const char**) {
        auto& builder = *static_cast<Builder*>(self);
        builder.guarded([&] {
            if (builder.open_.size() > kMaxDepth || ++builder.num_elements_ > kMaxElements)
                return builder.stop();
            auto& siblings = builder.open_.back()->children;
            siblings.push_back({.name = name, .text = {}, .children = {}});
            builder.open_.push_back(&siblings.back());
        });
    }
    static void on_end(void* self, const char*) { static_cast<Builder*>(self)->open_.pop_back(); }
    static void on_text(void* self, const char* text, int size) {
        auto& builder = *static_cast<Builder*>(self);
        builder.guarded(
            [&] { builder.open_.back()->text.append(text, static_cast<std::size_t>(size)); });
    }
    static void on_doctype(void* self, const char*, const char*, const char*, int) {
        static_cast<Builder*>(self)->stop();
    }

    template <typename Work>
    void guarded(const Work& work) {
        try {
            work();
        } catch (const std::exception&) {
            stop();
        }
    }
    void stop() { XML_StopParser(parser_, XML_FALSE); }

    XML_Parser parser_;
    XmlNode root_;
    std::vector<XmlNode*> open_{&root_};  // a child is complete before its next sibling begins
    std::size_t num_elements_ = 0;
};

}  // namespace

std::string XmlNode::text_of(std::string_view child) const {
    for (const XmlNode& node : children)
        if (node.name == child) return node.text;
    return "";
}

XmlNode parse_xml(std::string_view document) {
    if (document.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        Builder::throw_unreadable("it is too long");
    const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr),
                                                                         XML_ParserFree);
    if (!parser) throw std::bad_alloc();
    Builder builder(parser.get());
    if (XML_Parse(parser.get(), document.data(), static_cast<int>(document.size()), XML_TRUE) !=
        XML_STATUS_OK)
        Builder::throw_unreadable(XML_ErrorString(XML_GetErrorCode(parser.get())));
    return builder.take_root();
}

}  // namespace divemesh::storage
