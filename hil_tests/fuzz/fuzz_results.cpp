#include "common/bus/compensation.hpp"
#include "common/bus/display.hpp"
#include "common/bus/job.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/recording.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/setup.hpp"
#include "common/bus/tap.hpp"
#include "common/bus/transfer_function_report.hpp"
#include "common/bus/weight_check.hpp"
#include "hil_tests/fuzz/round_trip.hpp"
#include "hil_tests/fuzz/shown.hpp"
#include "tools/views/compensation_json.hpp"
#include "tools/views/order_lines.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/weight_check_line.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {
namespace {

using fuzz::Shown;

std::array<Balance, kWheels> four(const Balance& balance) {
  return {balance, balance, balance, balance};
}

Shown shown(const Balance& balance) {
  return {{balance_line(balance)}, wheels_json({}, four(balance))};
}

// Beside a balance that is known: of another there is no plan.
Shown shown(const Compensation& plan) {
  const Balance known{.wheel = plan.wheel, .state = Unknown::kNone};
  return {advice_lines(known, plan), compensation_json(four(known), {plan, plan, plan, plan})};
}

Shown shown(const Identification& identification) {
  std::vector<std::string> lines = suspension_lines(identification);
  lines.push_back(identification_line(identification));
  return {lines, wheels_json(identification, four(Balance{.state = Unknown::kNone}))};
}

Shown shown(const OrderReport& report) {
  return {order_lines(report), order_report_json(report)};
}

Shown shown(const WeightCheck& wheel) {
  return {{weight_check_line(wheel)}, weight_check_json(wheel)};
}

// Each as rb watch shows it.
void check_displays(std::span<const std::uint8_t> bytes) {
  const auto show = [](const auto& message) { return shown(message); };
  fuzz::check_shown<Level>(bytes, decode_level, [](const Level& level) {
    return Shown{level_lines(level), nullptr};
  });
  fuzz::check_shown<Balance>(bytes, decode_balance, show);
  fuzz::check_shown<Compensation>(bytes, decode_compensation, show);
  fuzz::check_shown<Identification>(bytes, decode_identification, show);
  fuzz::check_shown<OrderReport>(bytes, decode_orders, show);
  fuzz::check_shown<WeightCheck>(bytes, decode_weight_check, show);
  fuzz::check_shown<Remark>(bytes, decode_remark, [](const Remark& remark) {
    return Shown{{remark.text}, remark.text};
  });
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const std::span<const std::uint8_t> bytes(data, size);
  fuzz::check_message<Level>(bytes, decode_level);
  fuzz::check_message<SpectrumPart>(bytes, decode_spectrum);
  fuzz::check_message<Identification>(bytes, decode_identification);
  fuzz::check_message<Balance>(bytes, decode_balance);
  fuzz::check_message<OrderReport>(bytes, decode_orders);
  fuzz::check_message<Compensation>(bytes, decode_compensation);
  fuzz::check_message<View>(bytes, decode_view);
  fuzz::check_message<TransferFunctionPart>(bytes, decode_transfer_function);
  fuzz::check_message<Envelope>(bytes, decode_envelope);
  fuzz::check_message<WaterfallRow>(bytes, decode_waterfall);
  fuzz::check_message<Remark>(bytes, decode_remark);
  fuzz::check_message<Tap>(bytes, decode_tap);
  fuzz::check_message<NodeSetup>(bytes, decode_setup);
  fuzz::check_message<WeightCheck>(bytes, decode_weight_check);
  fuzz::check_message<RecordingSummary>(bytes, decode_recording);
  fuzz::check_message<Job>(bytes, decode_job);
  fuzz::check_message<DocumentPart>(bytes, decode_document_part);
  check_displays(bytes);
  return 0;
}
