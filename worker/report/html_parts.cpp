#include "worker/report/html_parts.hpp"

#include "schemas/base64.hpp"
#include "worker/report/svg_plot.hpp"

namespace divemesh::worker {
namespace {

using nlohmann::json;

constexpr char kStyle[] = R"(
body{font:15px/1.5 system-ui,sans-serif;color:#1b2a33;max-width:1180px;margin:2rem auto;padding:0 1rem}
h1{font-size:1.5rem;margin:0}h2{font-size:1.1rem;margin:1.6rem 0 .4rem}.sub{color:#5b6b75}
.row{display:flex;flex-wrap:wrap;gap:1.5rem;align-items:flex-start}.row>*{flex:1 1 340px;min-width:0}
table{border-collapse:collapse;width:100%}td,th{padding:.22rem .6rem;border-bottom:1px solid #dfe6ea;text-align:left;vertical-align:top}
td.value{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
svg{width:100%;height:auto;border:1px solid #dfe6ea;border-radius:4px}svg text{font:11px system-ui,sans-serif;fill:#415059}
svg .title{font-size:13px;font-weight:600;fill:#1b2a33}svg .grid{stroke:#e4eaee}
img{max-width:100%;border:1px solid #dfe6ea;border-radius:4px;background:#fff}
th{font-weight:600;color:#415059}.scroll{max-height:32rem;overflow:auto}
.met{color:#1c6b3a}.scale{display:flex;align-items:center;gap:.5rem;margin:.3rem 0}.scale i{flex:1;height:12px;border-radius:2px}
.error,.unmet{color:#a3231f}.warning{color:#8a5a00}.info{color:#2f5d7c})";

}  // namespace

std::string html_head(const std::string& title, const std::string& style) {
    return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
           escape_html(title) + "</title><style>" + kStyle + style + "</style></head>";
}

std::string html_table(const std::string& title, const HtmlRows& rows) {
    if (rows.empty()) return "";
    std::string html = "<section><h2>" + escape_html(title) + "</h2><table>";
    for (const auto& [name, value] : rows)
        html += "<tr><td>" + escape_html(name) + "</td><td class=\"value\">" + escape_html(value) +
                "</td></tr>";
    return html + "</table></section>";
}

std::string html_grid(const std::vector<std::vector<std::string>>& rows) {
    std::string html = "<table>";
    for (std::size_t i = 0; i < rows.size(); ++i) {
        html += "<tr>";
        for (const std::string& cell : rows[i])
            html += (i == 0 ? "<th>" : "<td>") + escape_html(cell) + (i == 0 ? "</th>" : "</td>");
        html += "</tr>";
    }
    return html + "</table>";
}

std::string html_picture(const std::string& png, const std::string& alt) {
    return "<img alt=\"" + escape_html(alt) + "\" src=\"data:image/png;base64," +
           encode_base64(png) + "\">";
}

std::string html_findings(const json& list) {
    if (list.empty()) return "<p>None.</p>";
    std::string html = "<table>";
    for (const json& finding : list) {
        const auto text = [&](const char* key) {
            return escape_html(finding.value(key, std::string()));
        };
        html += "<tr><td class=\"" + text("severity") + "\">" + text("severity") + "</td><td>" +
                text("where") + "</td><td>" + text("message") + "</td><td>" + text("remedy") +
                "</td></tr>";
    }
    return html + "</table>";
}

}  // namespace divemesh::worker
