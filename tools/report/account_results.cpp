#include <algorithm>
#include <cmath>

#include "common/clock/utc.hpp"
#include "common/text/format.hpp"
#include "common/text/markup.hpp"
#include "tools/report/account_sections.hpp"
#include "tools/report/html_parts.hpp"
#include "tools/views/alarm_lines.hpp"
#include "tools/views/compensation_json.hpp"
#include "tools/views/degrees.hpp"
#include "tools/views/identification_json.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/weight_check_line.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Rows = std::vector<std::vector<std::string>>;

std::string words_of(const Json& value) {
  return value.is_null() ? "–" : words(value.get<std::string>());
}

/// {"value", "sigma"}
std::string estimate(const Json& of, const char* pattern, double factor = 1.0) {
  return with_reach(of["value"], of["sigma"], pattern, factor);
}

std::string unbalances(const Json& wheels) {
  Rows rows;
  for (const Json& wheel : wheels)
    rows.push_back({words_of(wheel["name"]), with_reach(wheel["unbalance_g"], wheel["sigma_g"], "%.2f"),
                    with_reach(wheel["angle_deg"], wheel["sigma_deg"], "%.1f"),
                    with_reach(wheel["force_n"], wheel["sigma_force_n"], "%.1f"),
                    words_of(wheel["force_state"])});
  return table(
      {"wheel", "unbalance, g", "heavy spot, °", "force that does not grow with speed, N", "told apart"},
      rows);
}

std::string stiffnesses(const Json& wheels, const Json& suspension) {
  const bool sprung = !suspension.is_null();
  Rows rows;
  for (std::size_t w = 0; w < kWheels; ++w)
    rows.push_back(
        {words_of(wheels[w]["name"]),
         with_reach(wheels[w]["tyre_stiffness_n_m"], wheels[w]["sigma_tyre_stiffness_n_m"], "%.1f", 1e-3),
         sprung ? estimate(suspension["spring_n_m"][w], "%.2f", 1e-3) : "–",
         sprung ? estimate(suspension["damper_n_s_m"][w], "%.0f") : "–"});
  const std::string html = table({"wheel", "tyre, kN/m", "spring, kN/m", "damper, N s/m"}, rows);
  if (!sprung) return html;
  return html +
         paragraph("Stabilisers: front " + estimate(suspension["stabiliser_n_m"][0], "%.2f", 1e-3) +
                   " kN/m, rear " + estimate(suspension["stabiliser_n_m"][1], "%.2f", 1e-3) + " kN/m.");
}

std::string classes(const Json& speeds) {
  Rows rows;
  for (const Json& one : speeds)
    rows.push_back({figure(one["speed_m_s"], "%.1f", 3.6), figure(one["seconds"], "%.1f")});
  return rows.empty() ? "" : table({"steady at, km/h", "s"}, rows);
}

std::string steps(const Json& list) {
  if (list.is_null()) return "–";
  std::string text;
  for (const Json& step : list) {
    text += (text.empty() ? "" : "; ") + words_of(step["action"]) + " " + figure(step["mass_g"], "%g") + " g";
    if (step.contains("from_deg")) text += " from " + figure(step["from_deg"], "%.0f") + "°, now";
    text += " at " + figure(step["angle_deg"], "%.0f") + "°";
    if (!step["plane"].is_null()) text += ", " + words_of(step["plane"]) + " plane";
    if (!step["kind"].is_null()) text += ", " + words_of(step["kind"]);
  }
  return text.empty() ? "none" : text;
}

/// "35.0 at 217°" of [x, y].
std::string polar(const Json& vector) {
  if (vector.is_null()) return "–";
  const double x = vector[0].get<double>(), y = vector[1].get<double>();
  return format("%.1f at %.0f°", std::hypot(x, y), std::fmod(degrees(std::atan2(y, x)) + 360.0, 360.0));
}

std::string gaps(const Json& proof) {
  const Json& nodes = proof["nodes"];
  Rows rows;
  for (const Json& node : nodes) {
    for (const Json& gap : node["gaps"])
      rows.push_back({node["node"].dump(), gap["first_scan"].dump(),
                      gap["scans_known"].get<bool>() ? gap["scans"].dump() : "not known",
                      figure(gap["milliseconds"], "%.1f"), words_of(gap["cause"])});
    for (const Json& span : node["undeclared_scans"])
      rows.push_back(
          {node["node"].dump(), span["first"].dump(),
           std::to_string(span["last"].get<std::int64_t>() - span["first"].get<std::int64_t>() + 1), "–",
           "missing, undeclared"});
  }
  const bool ended = std::ranges::all_of(nodes, [](const Json& node) { return node["ended"].get<bool>(); });
  return (rows.empty() ? "" : table({"node", "from sample", "samples", "ms", "cause"}, rows)) +
         (ended ? "" : paragraph("What came after the last block of a node without its end is not known.")) +
         (ended && rows.empty()
              ? paragraph(std::string("No sample between begin and end of a node is missing") +
                          (proof["absent"].empty() ? "." : ", but a node was absent."))
              : "");
}

std::string damage(const Json& proof) {
  Rows rows;
  for (const char* const list : {"damage", "indexes"})
    for (const Json& line : proof[list]) rows.push_back({line.get<std::string>()});
  for (const Json& node : proof["nodes"])
    for (const Json& line : node["contradictions"]) rows.push_back({line.get<std::string>()});
  return rows.empty() ? "" : table({"damage"}, rows);
}

std::string absences(const Json& proof) {
  Rows rows;
  for (const Json& node : proof["absent"]) rows.push_back({node["text"].get<std::string>()});
  return rows.empty() ? "" : table({"absent"}, rows);
}

}  // namespace

std::string account_identification(const DriveReport& report) {
  const auto& [identification, balance] = report.found.estimate;
  const Json wheels = wheels_json(identification, balance);
  std::string remarks;
  for (const std::string& remark : report.found.diagnostics)
    remarks += element("li", markup_text(remark + "."));
  return element("h2", "Identification") +
         paragraph(identification_line(identification, report.found.refusal) + ".") + unbalances(wheels) +
         stiffnesses(wheels, suspension_json(identification)) + classes(speeds_json(identification)) +
         (remarks.empty() ? "" : element("ul", remarks)) +
         element("p", "± is one standard deviation.", "facts");
}

std::string account_weights(const DriveReport& report) {
  Rows rows;
  for (const Json& wheel : compensation_json(report.found.estimate.balance, report.found.compensation))
    rows.push_back({words_of(wheel["name"]), words_of(wheel["advice"]), steps(wheel["steps"]),
                    figure(wheel["residual_g"], "%.1f"), figure(wheel["shop_g"], "%g"),
                    figure(wheel["permissible_g"], "%.1f"), words_of(wheel["judged_by"]),
                    words_of(wheel["incurable"])});
  return element("h2", "Weights") + table({"wheel", "advice", "steps", "leaves, g", "shop leaves, g",
                                           "permissible, g", "judged by", "weights will not cure"},
                                          rows);
}

std::string account_before_and_after(const DriveReport& report) {
  const std::string title = element("h2", "Before and after the weights");
  if (!report.weight_check) return title + paragraph("No drive before the weights was given.");
  Rows rows;
  for (const WeightCheck& of : *report.weight_check) {
    const Json wheel = weight_check_json(of);
    rows.push_back({words_of(wheel["wheel"]), polar(wheel["before_g"]), polar(wheel["fitted_g"]),
                    polar(wheel["after_g"]),
                    with_reach(wheel["reduction"], wheel["sigma_reduction"], "%.0f", 100.0),
                    words_of(wheel["verdict"]), words_of(wheel["placement"])});
  }
  return title +
         table({"wheel", "before, g", "fitted, g", "now, g", "less by, %", "verdict", "weights are placed"},
               rows);
}

std::string account_alarms(const DriveReport& report) {
  Rows rows;
  for (const Json& alarm : recorded_alarms_json(report.alarms.all()))
    rows.push_back({words_of(alarm["level"]), words_of(alarm["where"]), words_of(alarm["what"]),
                    utc_text(alarm["began_us"].get<std::int64_t>()),
                    alarm["ended_us"].is_null() ? "–" : utc_text(alarm["ended_us"].get<std::int64_t>()),
                    alarm["text"].get<std::string>()});
  std::string html = element("h2", "Alarms");
  if (rows.empty()) return html + paragraph("No alarm is in the record.");
  html += table({"level", "where", "what", "began", "ended", "text"}, rows);
  if (report.alarms.left_out() > 0)
    html += paragraph(format("%zu more began, too many to be kept.", report.alarms.left_out()));
  return html;
}

std::string account_proof(const DriveReport& report) {
  const Json& proof = report.account->proof;
  Rows rows;
  for (const Json& node : proof["nodes"])
    rows.push_back({node["node"].dump(), node["epoch"].dump(), node["blocks"].dump(),
                    node["samples_sent"].dump(), node["samples_recorded"].dump(),
                    node["samples_missing"].dump(), std::to_string(node["gaps"].size()),
                    node["losses"]["repaired"].dump(), node["ended"].get<bool>() ? "yes" : "no",
                    node["absent"].get<bool>()     ? "was absent"
                    : node["complete"].get<bool>() ? "complete"
                                                   : "not complete"});
  const auto count = [&](const char* key) { return proof[key].dump(); };
  return element("h2", "Proof of completeness") +
         paragraph("The recording is " + words_of(proof["verdict"]) + ".") +
         table({"node", "epoch", "blocks", "samples sent", "recorded", "missing", "gaps", "repaired",
                "has its end", "verdict"},
               rows) +
         paragraph(count("events") + " events were read, " + count("journal_entries") +
                   " journal entries compared with the blocks. Refused for a wrong CRC, size or content: " +
                   count("blocks_refused") + " blocks, " + count("entries_refused") +
                   " other entries. Altered headers: " + count("altered_headers") + "; damaged bytes: " +
                   count("damaged_bytes") + "; torn bytes at the end: " + count("torn_bytes") +
                   "; segments missing: " + count("missing_segments") +
                   ", deleted: " + count("deleted_segments") + ".") +
         gaps(proof) + absences(proof) + damage(proof);
}

}  // namespace roadbalance
