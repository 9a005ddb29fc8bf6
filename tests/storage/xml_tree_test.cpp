#include "storage/xml_tree.hpp"

#include <gtest/gtest.h>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

testing::AssertionResult is_refused(const std::string& document) {
    return throws_code(ErrorCode::Unavailable, [&] { parse_xml(document); });
}

std::string nested(int depth) {
    std::string text;
    for (int i = 0; i < depth; ++i) text += "<a>";
    for (int i = 0; i < depth; ++i) text += "</a>";
    return text;
}

TEST(XmlTreeTest, ReadsElementsInTheirOrderWithTheirText) {
    const XmlNode root = parse_xml(
        "<?xml version=\"1.0\"?><List xmlns=\"urn:x\"><Key>a&amp;b</Key><Owner><Id>1</Id></Owner>"
        "<Key>c<![CDATA[<d>]]></Key><Empty/></List>");
    EXPECT_EQ(root.name, "List");
    ASSERT_EQ(root.children.size(), 4U);
    EXPECT_EQ(root.text_of("Key"), "a&b");
    EXPECT_EQ(root.children[1].text_of("Id"), "1");
    EXPECT_EQ(root.children[2].text, "c<d>");
    EXPECT_EQ(root.text_of("Empty"), "");
    EXPECT_EQ(root.text_of("Missing"), "");
}

TEST(XmlTreeTest, RefusesWhatIsNotWellFormed) {
    for (const std::string document :
         {"", "  ", "text", "<a>", "<a></b>", "<a/><b/>", "<a>&x;</a>"})
        EXPECT_TRUE(is_refused(document)) << document;
}

TEST(XmlTreeTest, RefusesEntitiesAndDocumentTypes) {
    EXPECT_TRUE(is_refused("<!DOCTYPE a [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><a>&x;</a>"));
    EXPECT_TRUE(is_refused("<!DOCTYPE a><a/>"));
}

TEST(XmlTreeTest, BoundsDepthAndElements) {
    EXPECT_NO_THROW(parse_xml(nested(16)));
    EXPECT_TRUE(is_refused(nested(17)));
    EXPECT_TRUE(is_refused(nested(100'000)));
    std::string many = "<a>";
    for (int i = 0; i < 50'000; ++i) many += "<b/>";
    EXPECT_TRUE(is_refused(many + "</a>"));
}

}  // namespace
}  // namespace divemesh::storage
