#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "host/analysis/balance/check_weights.hpp"
#include "tools/report/report_html.hpp"
#include "tools/report/report_wheel.hpp"
#include "tools/views/verification_json.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// 35 g at 217 degrees in front, 35 g at 37 to add; nothing known behind.
DriveReport report() {
  DriveReport report;
  report.vehicle.name = "a <b> & \"c\"";
  report.receipt.name = "drive<1>";
  report.receipt.verdict = "complete";
  report.receipt.node = {
      {.node = 1, .samples = 640'000, .repaired = 3, .seconds = 320.0, .sync_residual_s = 12e-6}};
  for (std::size_t w = 0; w < kWheels; ++w) {
    Balance& balance = report.found.estimate.balance[w];
    balance.wheel = static_cast<std::int32_t>(w);
    balance.weight_radius_m = 0.19;
    if (w > 1) continue;
    balance.state = Unknown::kNone;
    balance.unbalance_g = 35.0;
    balance.angle_rad = 217 * kDegree;
    balance.sigma_g = 1.234;
    balance.sigma_rad = 2.5 * kDegree;
    Compensation& compensation = report.found.compensation[w];
    compensation.wheel = balance.wheel;
    compensation.advice = Advice::kSteps;
    const WeightPlace place = w == 0 ? WeightPlace{0.19, WeightKind::kClip, RimPlane::kOuter}
                                     : WeightPlace{0.19, WeightKind::kAdhesive, RimPlane::kInner};
    compensation.plan.step = {{WeightAction::kAdd, {35.0, 37 * kDegree, place}, {}}};
    compensation.verdict.residual_g = 2.6;
    compensation.verdict.shop_g = 7.0;
  }
  return report;
}

bool says(const std::string& html, const std::string& part) {
  return html.find(part) != std::string::npos;
}

TEST(Report, DrawsHollowWhatTheWheelHides) {
  const std::string html = report_html(report());
  EXPECT_TRUE(says(html, "<circle class=\"new\""));
  EXPECT_TRUE(says(html, "<circle class=\"new hidden\""));
  EXPECT_TRUE(says(html, "hollow: behind the wheel, on the side of the car"));
}

TEST(Report, DrawsHollowWhatIsMovedAwayFromBehindTheWheel) {
  DriveReport of = report();
  const WeightPlace behind{0.19, WeightKind::kClip, RimPlane::kInner},
      before{0.19, WeightKind::kClip, RimPlane::kOuter};
  WeightStep& step = of.found.compensation[0].plan.step[0];
  step = {WeightAction::kMove, {35.0, 37 * kDegree, before}, {35.0, 90 * kDegree, behind}};
  std::string html = report_html(of);
  EXPECT_TRUE(says(html, "<circle class=\"off hidden\""));
  EXPECT_FALSE(says(html, "<circle class=\"off\""));
  std::swap(step.weight.place, step.from.place);
  html = report_html(of);
  EXPECT_TRUE(says(html, "<circle class=\"off\""));
  EXPECT_FALSE(says(html, "<circle class=\"off hidden\""));
  // In the cascade the later of two rules as narrow wins: what hides must be narrower than what takes off.
  EXPECT_TRUE(says(html, ".wheel .off.hidden { fill: #fff;"));
}

TEST(Report, TellsWeightsAtTheirPlaceOnBothSides) {
  const std::string html = report_html(report());
  // 12 - 217 / 30 and 12 - 37 / 30 on the left, 217 / 30 and 37 / 30 on the right.
  EXPECT_TRUE(says(html, "Clip 35 g at 37° on the outer flange (clock 10:46)."));
  EXPECT_TRUE(says(html, "Heavy spot at 217° (clock 4:46), 35.0 g ± 1.2 g ± 3°, at 190 mm."));
  EXPECT_TRUE(says(html, "Stick 35 g at 37° in the inner plane (clock 1:14)."));
  EXPECT_TRUE(says(html, "Heavy spot at 217° (clock 7:14)"));
  // 37 degrees of a turn of 190 mm: 0.6458 * 190 = 122.7 mm.
  EXPECT_TRUE(says(html, ">123 mm ahead of the valve.<"));
  EXPECT_TRUE(says(html, "Leaves 2.6 g, within what a shop leaves (7 g); at "));
  EXPECT_TRUE(says(html, "That is 49 g·cm."));
  EXPECT_TRUE(says(html, "Not known: not enough driving at a steady speed yet."));
}

TEST(Report, DrawsTheHeavySpotMirroredOnTheOtherSide) {
  const DriveReport of = report();
  for (const std::size_t w : {0U, 1U}) {
    const std::string svg = wheel_svg(of.found.estimate.balance[w], of.found.compensation[w], 35.0);
    // At 143 degrees from the top, to the right on a left wheel: 4:46 is below the hub, on the right.
    const double x = 40.0 * std::sin(143 * kDegree) * (w == 0 ? 1.0 : -1.0),
                 y = -40.0 * std::cos(143 * kDegree);
    char spot[64];
    std::snprintf(spot, sizeof spot, "class=\"spot\" cx=\"%.2f\" cy=\"%.2f\"", x, y);
    EXPECT_TRUE(says(svg, spot)) << svg;
  }
}

TEST(Report, DrawsWhatWasBeforeTheWeightsMirroredLikeAllElse) {
  const DriveReport of = report();
  for (const std::size_t w : {0U, 1U}) {
    WeightCheck before{.wheel = static_cast<std::int32_t>(w)};
    before.state = WeightCheckState::kKnown;
    before.before_g << 0.0, 17.5;  // at 90 degrees, half of the full scale
    const auto& balance = of.found.estimate.balance[w];
    const std::string svg = wheel_svg(balance, of.found.compensation[w], 35.0, &before);
    EXPECT_TRUE(says(
        svg, w == 0 ? "class=\"before\" d=\"M0 0L-20.00 -0.00\"" : "class=\"before\" d=\"M0 0L20.00 -0.00\""))
        << svg;
    before.state = WeightCheckState::kBeforeUnknown;
    EXPECT_FALSE(says(wheel_svg(balance, of.found.compensation[w], 35.0, &before), "class=\"before\""));
  }
}

TEST(Report, EscapesWhatComesOfARecording) {
  const std::string html = report_html(report());
  EXPECT_TRUE(says(html, "a &lt;b&gt; &amp; &quot;c&quot;"));
  EXPECT_TRUE(says(html, "drive&lt;1&gt;"));
  EXPECT_FALSE(says(html, "<b>"));
}

TEST(Report, TakesNothingFromElsewhere) {
  const std::string html = report_html(report());
  for (const char* const part : {"http:", "https:", "<script", "<link", "<img", "url(", "@import"})
    EXPECT_FALSE(says(html, part)) << part;
}

/// Text that a stranger may have written into any name or text of a recording.
constexpr const char* kHostile = "<script>alert('1')</script>\"><img src=x onerror=alert(2)>";

DriveReport hostile() {
  using Json = nlohmann::ordered_json;
  DriveReport of = report();
  of.vehicle.name = kHostile;
  of.vehicle.node = {
      {.name = kHostile, .id = 1, .rate_hz = 2000.0, .channel = {{.name = kHostile, .mount = kHostile}}}};
  of.vehicle.node[0].wiring.front_end = {kHostile};
  of.vehicle.node[0].wiring.can.emplace_back().interface = kHostile;
  of.vehicle.seat = {{.name = kHostile}};
  of.vehicle.rotor.emplace_back().name = kHostile;
  of.vehicle.wheel[0].name = of.vehicle.wheel[0].node = of.vehicle.wheel[0].encoder.counter = kHostile;
  of.vehicle.model.description = kHostile;
  of.receipt.mark = {{.time_us = 1, .text = kHostile, .number = 1}};
  of.found.diagnostics = {kHostile};
  of.failure = of.found.refusal = kHostile;
  of.alarms.take({.time_us = 1'000'000,
                  .kind = NoteKind::kAlarmBegan,
                  .a = static_cast<std::int64_t>(AlarmCause::kSamplesLost),
                  .b = 1,
                  .text = kHostile});
  Verification proof;
  proof.damage = proof.notes = proof.indexes = {kHostile};
  proof.epoch.emplace_back().contradictions = {kHostile};
  DriveAccount account;
  account.proof = verification_json(proof);
  account.levels = {{"channels",
                     {{{"channel", kHostile},
                       {"node", kHostile},
                       {"mean", 0.0},
                       {"rms", 1.0},
                       {"peak", 2.0},
                       {"seconds", 3.0},
                       {"overload", false},
                       {"clipped_s", 0.0},
                       {"dead_s", 0.0},
                       {"dc_offset_s", 0.0}}}},
                    {"wheels", Json::array()},
                    {"speed_classes", Json::array()}};
  account.orders = Json::array(
      {{{"wheel", kHostile},
        {"node", kHostile},
        {"seconds", 1.0},
        {"no_angle_s", 0.0},
        {"uncertain_angle_s", 0.0},
        {"too_slow_s", 0.0},
        {"gaps", 0},
        {"remark", kHostile},
        {"channels", Json::array({{{"channel", kHostile}, {"unit", "m/s^2"}, {"orders", Json::array()}}})}}});
  account.signals = Json::array({{{"name", kHostile},
                                  {"node", 1},
                                  {"signal", 0},
                                  {"quantity", kHostile},
                                  {"wheel", kHostile},
                                  {"unit", kHostile},
                                  {"samples", 1},
                                  {"first", 0.0},
                                  {"last", 0.0},
                                  {"least", 0.0},
                                  {"greatest", 0.0}}});
  account.missing = {kHostile};
  of.account = std::move(account);
  return of;
}

std::size_t count_of(const std::string& html, const std::string& part) {
  std::size_t count = 0;
  for (auto at = html.find(part); at != std::string::npos; at = html.find(part, at + 1)) ++count;
  return count;
}

TEST(Report, EscapesHostileTextsInEveryPartOfTheAccount) {
  DriveReport of = hostile();
  of.account->spectrum = {
      {.node = &of.vehicle.node[0], .channel = &of.vehicle.node[0].channel[0], .refusal = kHostile}};
  const std::string html = report_html(of);
  EXPECT_FALSE(says(html, "<script"));
  EXPECT_FALSE(says(html, "<img"));
  // Name of the car twice, and each of the other texts set above at least once.
  EXPECT_GE(count_of(html, "&lt;script&gt;"), 30U);
}

TEST(Report, CutsOnlyAWordThatNoColumnCanHold) {
  DriveReport of = hostile();
  of.vehicle.node[0].channel[0].name = std::string(64, 'W');
  const std::string html = report_html(of);
  EXPECT_TRUE(says(html, "<td class=\"long\">" + std::string(64, 'W') + "</td>"));
  EXPECT_TRUE(says(html, "<td>rear left</td>"));
}

TEST(Report, SaysOfAnAccountWhatIsMissing) {
  DriveReport of = report();
  of.vehicle_known = false;
  of.account.emplace();
  Verification proof;
  proof.epoch.emplace_back().undeclared_scans = {{100, 149}};
  of.account->proof = verification_json(proof);
  of.account->missing = {"orders: no wheel turned"};
  const std::string html = report_html(of);
  EXPECT_TRUE(says(html, "Not known: orders: no wheel turned."));
  EXPECT_TRUE(says(html, "<td>100</td>\n<td>50</td>"));
  EXPECT_TRUE(says(html, "What came after the last block of a node without its end is not known."));
  EXPECT_FALSE(says(html, "<h2>Vehicle</h2>"));
  EXPECT_FALSE(says(html, "<h2>Levels</h2>"));
}

TEST(Report, CallsNoNodeCompleteThatWasAbsent) {
  DriveReport of = report();
  of.account.emplace();
  Verification proof;
  proof.epoch.resize(2);
  for (std::size_t k = 0; k < 2; ++k) {
    proof.epoch[k].node = static_cast<std::int32_t>(k) + 1;
    proof.epoch[k].ended = true;
  }
  proof.absent = {{.node = 2, .text = "node 2 (rear) ended 38 s before the recording"}};
  of.account->proof = verification_json(proof);
  const std::string html = report_html(of);
  EXPECT_EQ(count_of(html, "<td>complete</td>"), 1u);
  EXPECT_EQ(count_of(html, "<td>was absent</td>"), 1u);
  EXPECT_TRUE(says(html, "is missing, but a node was absent."));
  EXPECT_TRUE(says(html, "<td>node 2 (rear) ended 38 s before the recording</td>"));
}

TEST(Report, ProvesCompleteness) {
  DriveReport of = report();
  EXPECT_TRUE(says(report_html(of), "<td>640000</td>"));
  EXPECT_TRUE(says(report_html(of), "12.0 µs"));
  EXPECT_TRUE(says(report_html(of), "The recording is complete. Every CRC is right."));
  of.receipt.refused = 2;
  EXPECT_TRUE(says(report_html(of), "2 blocks have a wrong CRC"));
}

TEST(Report, ListsTheAlarmsOfTheRecordTheWorstFirst) {
  DriveReport of = report();
  EXPECT_TRUE(says(report_html(of), "No alarm is in the record."));
  const auto note = [&](std::int64_t time_us, NoteKind kind, const Alarm& alarm, const char* text) {
    of.alarms.take({.time_us = time_us,
                    .kind = kind,
                    .a = static_cast<std::int64_t>(alarm.cause),
                    .b = place_number(alarm),
                    .text = text});
  };
  const Alarm no_signal{AlarmCause::kDeadChannel, 1, 4}, loss{AlarmCause::kSamplesLost, 2};
  note(1'000'000, NoteKind::kAlarmBegan, no_signal, "");
  note(2'000'000, NoteKind::kAlarmBegan, loss, "");
  note(9'000'000, NoteKind::kAlarmEnded, loss, "<35>");
  const std::string html = report_html(of);
  const std::size_t lost = html.find("00:00:02"), dead = html.find("WARNING node 1 channel 5: no signal");
  EXPECT_LT(lost, dead);
  EXPECT_NE(dead, std::string::npos);
  EXPECT_TRUE(says(html, "ALARM node 2: samples lost (&lt;35&gt;)."));
  for (int k = 0; k < 498; ++k) note(3'000'000, NoteKind::kAlarmBegan, no_signal, "");
  EXPECT_TRUE(says(report_html(of), "492 more: see rb info.")) << "the page stays one page";
  for (int k = 0; k < 10'000; ++k) note(3'000'000, NoteKind::kAlarmBegan, no_signal, "");
  EXPECT_TRUE(says(report_html(of), "10492 more: see rb info.")) << "those that are not kept count, too";
}

TEST(Report, TellsBeforeAndAfterIfBothWereDriven) {
  DriveReport of = report();
  EXPECT_FALSE(says(report_html(of), "Before and after"));
  of.weight_check = reading_before("drive0", of.found.estimate.balance);
  of.weight_check->at(0).state = WeightCheckState::kKnown;
  of.weight_check->at(0).verdict = WeightCheckVerdict::kGood;
  of.weight_check->at(0).before_g << 35.0, 0.0;
  of.weight_check->at(0).reduction = 1.0;
  EXPECT_TRUE(says(report_html(of), "Before and after"));
  EXPECT_TRUE(says(report_html(of), "before (drive0) 35.0 g, now 0.0 g: 100 % less"));
}

}  // namespace
}  // namespace roadbalance
