#include <algorithm>

#include "common/clock/utc.hpp"
#include "common/text/format.hpp"
#include "common/text/markup.hpp"
#include "tools/report/account_sections.hpp"
#include "tools/report/html_parts.hpp"
#include "tools/report/spectrum_chart.hpp"
#include "tools/views/recorded_spectra.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Rows = std::vector<std::vector<std::string>>;

std::string text_of(const Json& value) {
  return value.is_null() ? "–" : value.get<std::string>();
}

std::string wheels(const Json& levels) {
  Rows rows;
  for (const Json& wheel : levels["wheels"])
    rows.push_back({words(text_of(wheel["wheel"])), figure(wheel["seconds"], "%.1f"),
                    figure(wheel["turns"], "%.1f"), figure(wheel["slip"], "%+.3f", 100.0)});
  if (rows.empty()) return paragraph("Of no wheel is known how fast it turned.");
  return table({"wheel", "turned, s", "turns", "slip against the mean, %"}, rows);
}

std::string speeds(const Json& levels) {
  Rows rows;
  for (const Json& one : levels["speed_classes"])
    rows.push_back({figure(one["from_m_s"], "%.1f", 3.6) + " to " + figure(one["to_m_s"], "%.1f", 3.6),
                    figure(one["seconds"], "%.1f")});
  return rows.empty() ? "" : table({"speed, km/h", "driven, s"}, rows);
}

std::string signals(const Json& list) {
  Rows rows;
  for (const Json& one : list)
    rows.push_back({one["name"].is_null() ? one["signal"].dump() : text_of(one["name"]), one["node"].dump(),
                    words(text_of(one["quantity"])), words(text_of(one["wheel"])), text_of(one["unit"]),
                    figure(one["samples"], "%.0f"), figure(one["first"], "%g"), figure(one["last"], "%g"),
                    figure(one["least"], "%g"), figure(one["greatest"], "%g")});
  if (rows.empty()) return paragraph("No signal of the car's bus was recorded: no temperature, no weather.");
  return element("h3", "Signals of the car's bus") + table({"signal", "node", "quantity", "wheel", "unit",
                                                            "samples", "first", "last", "least", "greatest"},
                                                           rows);
}

std::string marks(const RecordingSummary& receipt) {
  Rows rows;
  for (const auto& mark : receipt.mark)
    rows.push_back({std::to_string(mark.number), utc_text(mark.time_us),
                    format("%.1f s", 1e-6 * static_cast<double>(mark.time_us - receipt.first_us)),
                    mark.text.empty() ? "–" : mark.text});
  if (rows.empty()) return paragraph("Nobody set a mark.");
  return element("h3", "Marks") + table({"mark", "at", "after the begin", "said"}, rows);
}

std::string notes(const Json& lines) {
  Rows rows;
  for (const Json& line : lines) rows.push_back({text_of(line)});
  return rows.empty() ? "" : element("h3", "Notes of the recorder") + table({"note"}, rows);
}

std::string remark_on(const Json& channel) {
  std::string text;
  if (channel["overload"].get<bool>()) text = "overload";
  const auto for_how_long = [&](const char* what, const Json& seconds) {
    if (seconds.get<double>() > 0.0)
      text += format("%s%s %.1f s", text.empty() ? "" : ", ", what, seconds.get<double>());
  };
  for_how_long("clipped", channel["clipped_s"]);
  for_how_long("dead", channel["dead_s"]);
  for_how_long("dc offset", channel["dc_offset_s"]);
  return text;
}

const char* unit_of(const ChannelConfig& channel) {
  return channel.role == ChannelRole::kRoad ? "m²/Hz" : "(m/s²)²/Hz";
}

std::string chart(const DriveAccount::Spectrum& of) {
  const std::string name = element("h4", markup_text(of.channel->name));
  if (of.averages == 0)
    return element(
        "figure",
        name + paragraph("No spectrum: " +
                         (of.refusal.empty() ? format("no stretch without a hole is %g s long", kSegment_s)
                                             : of.refusal) +
                         "."));
  const std::string caption =
      format("%s, %d averages, noise bandwidth %.3f Hz", unit_of(*of.channel), of.averages, of.enbw_hz);
  return element("figure", element("div", name + element("figcaption", caption), "caption") +
                               spectrum_chart(of.density, of.step_hz, of.independent));
}

/// In m/s^2, unless the unit is given.
std::string vector_of(const Json& order, const std::string& unit) {
  if (order["amplitude"].is_null()) return "–";
  const std::string phase = order["phase_deg"].is_null()
                                ? "no phase"
                                : with_reach(order["phase_deg"], order["phase_95_deg"], "%.1f") + "°";
  return with_reach(order["amplitude"], order["amplitude_95"], "%.4f") + unit + ", " + phase;
}

std::string orders_of(const Json& wheel) {
  std::vector<std::string> heads{"channel"};
  for (const double order : kAccountOrders) heads.push_back(format("order %g, m/s²", order));
  Rows rows;
  for (const Json& channel : wheel["channels"]) {
    rows.push_back({text_of(channel["channel"])});
    const std::string unit = channel["unit"] == "m" ? " m" : "";
    for (const Json& order : channel["orders"]) rows.back().push_back(vector_of(order, unit));
  }
  std::string text = format(
      "%.1f s, of which without angle %.1f s, angle uncertain %.1f s, too slow %.1f s; %d gaps.",
      wheel["seconds"].get<double>(), wheel["no_angle_s"].get<double>(),
      wheel["uncertain_angle_s"].get<double>(), wheel["too_slow_s"].get<double>(), wheel["gaps"].get<int>());
  if (const std::string remark = text_of(wheel["remark"]); !remark.empty()) text += " " + sentence(remark);
  const std::string title = words(text_of(wheel["wheel"])) + ", heard by node " + text_of(wheel["node"]);
  return element("div", element("h3", markup_text(title)) + paragraph(text) + table(heads, rows), "whole");
}

}  // namespace

std::string account_conditions(const DriveReport& report) {
  const RecordingSummary& receipt = report.receipt;
  double seconds = 0.0;
  for (const auto& node : receipt.node) seconds = std::max(seconds, node.seconds);
  std::string html = element("h2", "Conditions") +
                     paragraph(format("%.1f s of samples, written from %s to %s.", seconds,
                                      utc_text(receipt.first_us).c_str(), utc_text(receipt.last_us).c_str()));
  const DriveAccount& account = *report.account;
  if (!account.levels.is_null()) html += wheels(account.levels) + speeds(account.levels);
  if (!account.signals.is_null()) html += signals(account.signals);
  return html + marks(receipt) + notes(account.proof["notes"]);
}

std::string account_levels(const DriveReport& report) {
  if (report.account->levels.is_null()) return "";
  Rows rows;
  for (const Json& channel : report.account->levels["channels"])
    rows.push_back({text_of(channel["channel"]), text_of(channel["node"]), figure(channel["mean"], "%.3f"),
                    figure(channel["rms"], "%.3f"), figure(channel["peak"], "%.3f"),
                    figure(channel["seconds"], "%.1f"), remark_on(channel)});
  return element("h2", "Levels") +
         table({"channel", "node", "mean, m/s²", "rms, m/s²", "peak, m/s²", "over, s", "remark"}, rows) +
         element("p", "Rms and peak about the mean.", "facts");
}

std::string account_spectra(const DriveReport& report) {
  if (report.account->spectrum.empty()) return "";
  std::string charts;
  const NodeConfig* node = nullptr;
  std::string html;
  const auto close = [&] {
    if (node != nullptr) html += element("div", charts, "charts");
    charts.clear();
  };
  for (const DriveAccount::Spectrum& one : report.account->spectrum) {
    if (one.node != node) {
      close();
      node = one.node;
      html += element("h3", markup_text("Node " + node->name));
    }
    charts += chart(one);
  }
  close();
  return element("h2", "Spectra") +
         element("p",
                 markup_text(format("One-sided power spectral density, Hann window, segments of %g s, half "
                                    "overlapping, all of one weight. Marked: the peaks that stand out most.",
                                    kSegment_s)),
                 "facts") +
         html;
}

std::string account_orders(const DriveReport& report) {
  if (report.account->orders.is_null()) return "";
  std::string html = element("h2", "Orders") + element("p",
                                                       "Peak amplitude, and phase against the reference "
                                                       "point (the valve); ± is 95 %. Order 1 is once a turn "
                                                       "of the wheel.",
                                                       "facts");
  for (const Json& wheel : report.account->orders) html += orders_of(wheel);
  return html;
}

}  // namespace roadbalance
