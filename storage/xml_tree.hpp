#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace divemesh::storage {

// An element of an XML document with the text directly in it.
struct XmlNode {
    std::string name;
    std::string text;
    std::vector<XmlNode> children;

    // Returns the text of the first child of this name; "" if there is none.
    std::string text_of(std::string_view child) const;
};

// Reads a document that a server has sent. Throws Error{Unavailable} for one that is not well
// formed, has a document type, is nested more than 16 deep or has more than 50,000 elements.
XmlNode parse_xml(std::string_view document);

}  // namespace divemesh::storage
