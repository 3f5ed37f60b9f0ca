#include "tools/report/report_html.hpp"

#include <algorithm>
#include <cmath>

#include "common/clock/utc.hpp"
#include "common/text/format.hpp"
#include "common/text/markup.hpp"
#include "host/recording/verify/verify.hpp"
#include "tools/report/account_sections.hpp"
#include "tools/report/html_parts.hpp"
#include "tools/report/report_wheel.hpp"
#include "tools/views/degrees.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/weight_check_line.hpp"
#include "tools/views/wheel_angle.hpp"

namespace roadbalance {
namespace {

// Nothing from elsewhere: it is to be read where there is no network, and years later.
constexpr const char* kStyle = R"css(
@page { size: A4; margin: 12mm 14mm; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 182mm; font: 8.5pt/1.3 system-ui, "DejaVu Sans", sans-serif; color: #14181d; background: #fff; }
h1 { font-size: 15pt; margin: 0 0 1mm; }
h2 { font-size: 10pt; margin: 2.5mm 0 1mm; border-bottom: 0.3mm solid #b4bcc6; }
p { margin: 0 0 1mm; }
.facts { color: #4b5563; }
.wheels { display: grid; grid-template-columns: 1fr 1fr; gap: 2mm; }
.card { display: grid; grid-template-columns: 24mm 1fr; gap: 2mm; border: 0.3mm solid #b4bcc6; border-radius: 2mm; padding: 1.5mm 2mm; break-inside: avoid; }
.card h3 { margin: 0; font-size: 10pt; text-transform: capitalize; }
.step { font-weight: 700; font-size: 9.5pt; margin: 0; }
.bad { color: #b3131d; font-weight: 700; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 0.5mm 3mm 0.5mm 0; border-bottom: 0.2mm solid #d5dae0; }
td:first-child { white-space: nowrap; }
th { color: #4b5563; font-weight: 600; }
ul { margin: 0; padding-left: 5mm; }
footer { margin-top: 3mm; color: #4b5563; font-size: 8pt; }
.wheel { width: 24mm; }
.wheel .tyre { fill: #d5dae0; } .wheel .rim { fill: #fff; stroke: #6b7785; }
.wheel .mark, .wheel .tip { fill: #14181d; } .wheel .turn { fill: none; stroke: #14181d; stroke-width: 1.5; }
.wheel .before { stroke: #4b5563; stroke-width: 2; stroke-dasharray: 3 3; }
.wheel .vector { stroke: #0b57b7; stroke-width: 2.5; } .wheel .spot { fill: #a84300; }
.wheel .new { fill: #146c43; } .wheel .kept { fill: #6b7785; }
.wheel .hidden { fill: #fff; stroke: #146c43; stroke-width: 2; } .wheel .kept.hidden { stroke: #6b7785; }
.wheel .off { fill: #f0b9bd; stroke: #b3131d; stroke-width: 2; stroke-dasharray: 3 2; } .wheel .off.hidden { fill: #fff; stroke: #b3131d; }
.whole, tr, figure { break-inside: avoid; } h1, h2, h3, h4, h2 + .facts { break-after: avoid; }
.account { break-before: page; } .account h2 { margin-top: 4mm; } .account h3 { font-size: 9pt; margin: 2.5mm 0 0.5mm; }
.account table { font-size: 7pt; margin-bottom: 1.5mm; } .account th, .account td { padding: 0.4mm 2mm 0.4mm 0; vertical-align: top; } .long, p, li { overflow-wrap: anywhere; }
.account td:first-child { white-space: normal; }
.charts { display: grid; grid-template-columns: 1fr 1fr; gap: 2mm 4mm; } figure { margin: 0; min-width: 0; }
h1, h4 { overflow-wrap: anywhere; } h4 { font-size: 8pt; margin: 0; } figcaption { font-size: 7pt; color: #4b5563; white-space: nowrap; }
.caption { display: flex; flex-wrap: wrap; justify-content: space-between; align-items: baseline; gap: 0 2mm; }
.chart { width: 100%; display: block; } .chart text { font-size: 8.5px; fill: #14181d; }
.chart .grid { stroke: #d5dae0; stroke-width: 0.6; } .chart .curve { fill: none; stroke: #0b57b7; stroke-width: 0.9; stroke-linejoin: round; }
.chart .peak { fill: #a84300; }
.wheel text { font-size: 24px; text-anchor: middle; fill: #6b7785; }
)css";

/// "37° (clock 10:46)"
std::string where(std::int32_t wheel, double angle_rad) {
  const long whole = (std::lround(degrees(angle_rad)) % 360 + 360) % 360;
  return format("%ld° (clock %s)", whole, clock_of(angle_rad, wheel % 2 == 0).c_str());
}

/// The steps of the readout, each with the clock and where a ruler finds its place.
std::string advice(const Balance& balance, const Compensation& compensation) {
  std::string html;
  const std::vector<std::string> words_of = step_words(compensation);
  for (std::size_t k = 0; k < words_of.size(); ++k) {
    if (compensation.advice != Advice::kSteps) {
      html += element("p", markup_text(sentence(words_of[k])), "step");
      continue;
    }
    const WheelWeight& weight = compensation.plan.step[k].weight;
    const std::string clock = clock_of(weight.angle_rad, balance.wheel % 2 == 0);
    html += element("p", markup_text(sentence(words_of[k] + " (clock " + clock + ")")), "step");
    html += element("p", markup_text(along_rim(weight.angle_rad, weight.place.radius_m) + "."), "rim-place");
  }
  return html;
}

std::string what_is_left(const Balance& balance, const Compensation& compensation) {
  if (compensation.advice == Advice::kUnknown) return "";
  std::string text = sentence(left_words(balance, compensation));
  text += format(" That is %.0f g·cm.", 100.0 * compensation.verdict.residual_g * balance.weight_radius_m);
  if (std::isfinite(compensation.seat_now_m_s2))
    text += format(" Seats %.2g → %.2g m/s² rms.", compensation.seat_now_m_s2, compensation.seat_left_m_s2);
  return element("p", markup_text(text));
}

const WeightCheck* before_of(const DriveReport& report, std::size_t w) {
  return report.weight_check ? &report.weight_check->at(w) : nullptr;
}

std::string wheel_card(const DriveReport& report, std::size_t w, double rim_g) {
  const Balance& balance = report.found.estimate.balance[w];
  const Compensation& compensation = report.found.compensation[w];
  std::string text = element("h3", words(kWheelNames[w]));
  if (!compensation.verdict.incurable.empty())
    text += element("p", markup_text("Weights will not cure this: " + compensation.verdict.incurable + "."),
                    "bad");
  text += advice(balance, compensation);
  if (balance.state == Unknown::kNone)
    text += element("p", markup_text("Heavy spot at " + where(balance.wheel, balance.angle_rad) +
                                     format(", %.1f g ± %.1f g ± %.0f°, at %.0f mm.", balance.unbalance_g,
                                            shown_sigma(balance.sigma_g, 0.1),
                                            std::min(180.0, std::ceil(degrees(balance.sigma_rad))),
                                            1e3 * balance.weight_radius_m)));
  else
    text += element(
        "p", markup_text("Not known: " +
                         (report.failure.empty() ? reason(balance.state) : "see what this rests on") + "."));
  text += what_is_left(balance, compensation);
  return element("div", wheel_svg(balance, compensation, rim_g, before_of(report, w)) + element("div", text),
                 "card");
}

std::string wheels(const DriveReport& report) {
  double largest_g = 5.0;
  for (const Balance& balance : report.found.estimate.balance)
    if (balance.state == Unknown::kNone) largest_g = std::max(largest_g, balance.unbalance_g);
  if (report.weight_check)
    for (const WeightCheck& wheel : *report.weight_check)
      if (tells_before(wheel)) largest_g = std::max(largest_g, wheel.before_g.norm());
  std::string cards;
  for (std::size_t w = 0; w < kWheels; ++w) cards += wheel_card(report, w, largest_g);
  return element("h2", "Wheels, as seen from outside the car, the reference point (the valve) at 12") +
         element("div", cards, "wheels") +
         element(
             "p",
             markup_text(format(
                 "A line to the rim is %.0f g. ± is one standard deviation. Orange: heavy spot; green: "
                 "weight; red, dashed: take off; hollow: behind the wheel, on the side of the car; dashed: "
                 "before the weights.",
                 largest_g)),
             "facts");
}

std::string before_and_after(const DriveReport& report) {
  if (!report.weight_check) return "";
  std::string lines;
  for (const WeightCheck& wheel : *report.weight_check)
    lines += element("tr", element("td", words(kWheelNames[static_cast<std::size_t>(wheel.wheel)])) +
                               element("td", markup_text(weight_check_line(wheel))));
  return element("h2", "Before and after the weights") + element("table", lines);
}

std::string completeness(const RecordingSummary& receipt) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& node : receipt.node)
    rows.push_back(
        {std::to_string(node.node), std::to_string(node.samples),
         node.absent ? "was absent" : std::to_string(node.samples_lost), std::to_string(node.repaired),
         format("%.1f s", node.seconds), format("%.1f s", node.overload_s),
         node.sync_residual_s < 0.0 ? "not known" : format("%.1f µs", 1e6 * node.sync_residual_s)});
  const std::string crc =
      receipt.refused == 0 && receipt.damaged_bytes == 0
          ? "Every CRC is right."
          : format("%lld blocks have a wrong CRC, %lld bytes are damaged.",
                   static_cast<long long>(receipt.refused), static_cast<long long>(receipt.damaged_bytes));
  return element("h2", "Proof of completeness") +
         element("p", markup_text("The recording is " + receipt.verdict + ". " + crc)) +
         table({"node", "samples", "lost", "blocks repaired", "time", "overload", "clock known to"}, rows);
}

/// The worst first; what does not go on the page is in `rb info`.
std::string alarm_list(const DriveReport& report) {
  constexpr std::size_t kMostLines = 8;
  std::vector<RecordedAlarm> alarms = report.alarms.all();
  if (alarms.empty()) return element("p", "No alarm is in the record.");
  std::ranges::stable_sort(alarms, std::ranges::greater{},
                           [](const RecordedAlarm& one) { return level_of(one.alarm.cause); });
  std::string list;
  for (std::size_t k = 0; k < std::min(alarms.size(), kMostLines); ++k)
    list += element("li", markup_text(utc_text(alarms[k].began_us) + " " + sentence(alarms[k]) + "."));
  if (const std::size_t all = alarms.size() + report.alarms.left_out(); all > kMostLines)
    list += element("li", format("%zu more: see rb info.", all - kMostLines));
  return element("h2", "Alarms") + element("ul", list);
}

std::string remarks(const DriveReport& report) {
  std::string list;
  if (!report.failure.empty()) list += element("li", markup_text(report.failure + "."));
  if (!report.found.refusal.empty()) list += element("li", markup_text(report.found.refusal + "."));
  for (const std::string& remark : report.found.diagnostics) list += element("li", markup_text(remark + "."));
  return list.empty() ? "" : element("h2", "What this rests on") + element("ul", list);
}

std::string suspension(const DriveReport& report) {
  const Identification& found = report.found.estimate.identification;
  std::string text = identification_line(found, report.found.refusal);
  if (found.state == Unknown::kNone) {
    text = "Tyres, kN/m: ";
    for (std::size_t w = 0; w < kWheels; ++w)
      text += format("%s%s %.0f ± %.0f", w == 0 ? "" : ", ", words(kWheelNames[w]).c_str(),
                     1e-3 * found.tyre_n_m[w], shown_sigma(1e-3 * found.sigma_tyre_n_m[w], 1.0));
  }
  return element("h2", "Car") + element("p", markup_text(text + "."));
}

std::string head(const DriveReport& report) {
  const Identification& identification = report.found.estimate.identification;
  std::string facts = "Recording " + report.receipt.name + ", " + utc_text(report.receipt.first_us) + " to " +
                      utc_text(report.receipt.last_us);
  if (!identification.speed_class.empty())
    facts += format("; %.0f s of steady driving at %.0f to %.0f km/h", identification.seconds_used,
                    3.6 * identification.speed_class.front().speed_m_s,
                    3.6 * identification.speed_class.back().speed_m_s);
  return element("h1", markup_text("Wheel balance: " + report.vehicle.name)) +
         element("p", markup_text(facts + "."), "facts");
}

/// Missing parts stand first.
std::string account(const DriveReport& report) {
  if (!report.account) return "";
  std::string missing;
  for (const std::string& part : report.account->missing)
    missing += element("li", markup_text("Not known: " + part + "."));
  std::string html = element("h1", "Account of the drive");
  if (!missing.empty()) html += element("ul", missing, "bad");
  if (report.vehicle_known)
    for (const auto section : {account_vehicle, account_sensors}) html += section(report);
  for (const auto section :
       {account_conditions, account_levels, account_spectra, account_orders, account_identification,
        account_weights, account_before_and_after, account_alarms, account_proof})
    html += section(report);
  return element("section", html, "account");
}

}  // namespace

std::string report_html(const DriveReport& report) {
  const std::string title = markup_text("Wheel balance: " + report.vehicle.name);
  return "<!doctype html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>" + title +
         "</title>\n<style>" + kStyle + "</style></head>\n<body>\n" + head(report) + wheels(report) +
         before_and_after(report) + suspension(report) + remarks(report) + completeness(report.receipt) +
         alarm_list(report) +
         element("footer",
                 "Made by rb report of the recording alone: the same recording gives the same page.") +
         account(report) + "</body>\n</html>\n";
}

}  // namespace roadbalance
