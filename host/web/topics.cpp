#include "host/web/topics.hpp"

#include <array>
#include <initializer_list>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/compensation.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/display.hpp"
#include "common/bus/job.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/recording.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/setup.hpp"
#include "common/bus/tap.hpp"
#include "common/bus/transfer_function_report.hpp"
#include "common/bus/weight_check.hpp"

namespace roadbalance {
namespace {

using Bytes = std::span<const std::uint8_t>;
using Key = std::optional<std::int64_t>;

template <typename Message>
Key node_of(const std::optional<Message>& message) {
  return message ? Key(message->node) : std::nullopt;
}

template <typename Message>
Key wheel_of(const std::optional<Message>& message) {
  return message && message->wheel >= 0 && message->wheel < kWheels ? Key(message->wheel) : std::nullopt;
}

/// One key for several numbers, unique among those in use.
std::int64_t packed(std::initializer_list<std::int64_t> values) {
  std::uint64_t key = 0;
  for (const std::int64_t value : values) key = key * 1021 + static_cast<std::uint64_t>(value);
  return static_cast<std::int64_t>(key);
}

Key transfer_function_key(Bytes bytes) {
  const auto part = decode_transfer_function(bytes);
  if (!part || part->viewer == 0) return std::nullopt;
  return packed({part->pair.input.node, part->pair.input.channel, part->pair.output.node,
                 part->pair.output.channel, part->part});
}

/// Only of spectra that a page asked for.
Key spectrum_key(Bytes bytes) {
  const auto part = decode_spectrum(bytes);
  if (!part || part->viewer == 0) return std::nullopt;
  return packed({part->node, part->channel, part->part});
}

Key envelope_key(Bytes bytes) {
  const auto envelope = decode_envelope(bytes);
  return envelope ? Key(packed({envelope->node, envelope->channel})) : std::nullopt;
}

Key waterfall_key(Bytes bytes) {
  const auto row = decode_waterfall(bytes);
  if (!row) return std::nullopt;
  return packed({row->of.wheel, row->of.channel.node, row->of.channel.channel, row->speed_class});
}

Key orders_key(Bytes bytes) {
  const auto report = decode_orders(bytes);
  return wheel_of(report) ? Key(packed({report->wheel, report->node})) : std::nullopt;
}

const std::array kPageMessages{
    PageMessage{kRecorderChannel,
                [](Bytes bytes) {
                  const auto status = decode_recorder_status(bytes);
                  return status ? Key(status->recorder) : std::nullopt;
                },
                true},
    // The newest of each asker and operation: a page sends one request of an operation at a time.
    PageMessage{kAnswerChannel,
                [](Bytes bytes) {
                  const auto answer = decode_answer(bytes);
                  return answer ? Key(answer->asker * 16 + static_cast<std::int64_t>(answer->operation) % 16)
                                : std::nullopt;
                },
                true, nullptr, 64, true},
    PageMessage{kReceiptChannel,
                [](Bytes bytes) {
                  const auto receipt = decode_receipt(bytes);
                  return receipt ? Key(receipt->index) : std::nullopt;
                },
                true},
    PageMessage{"RB_HEARTBEAT_.*", [](Bytes bytes) { return node_of(decode_heartbeat(bytes)); }, true},
    PageMessage{"RB_CLOCK_.*", [](Bytes bytes) { return node_of(decode_clock_fit(bytes)); }, true},
    PageMessage{kLevelChannel, [](Bytes bytes) { return node_of(decode_level(bytes)); }, true},
    PageMessage{kIdentificationChannel,
                [](Bytes bytes) { return decode_identification(bytes) ? Key(0) : std::nullopt; }, false},
    PageMessage{kBalanceChannel, [](Bytes bytes) { return wheel_of(decode_balance(bytes)); }, false},
    PageMessage{kCompensationChannel, [](Bytes bytes) { return wheel_of(decode_compensation(bytes)); },
                false},
    PageMessage{kRemarkChannel,
                [](Bytes bytes) {
                  const auto remark = decode_remark(bytes);
                  return remark ? Key(remark->number) : std::nullopt;
                },
                false},
    PageMessage{kTapChannel, [](Bytes bytes) { return node_of(decode_tap(bytes)); }, false, nullptr,
                kMostNodes},
    PageMessage{"RB_SETUP_.*", [](Bytes bytes) { return node_of(decode_setup(bytes)); }, true},
    PageMessage{kWeightCheckChannel, [](Bytes bytes) { return wheel_of(decode_weight_check(bytes)); }, false},
    PageMessage{kRecordingChannel,
                [](Bytes bytes) {
                  const auto recording = decode_recording(bytes);
                  return recording ? Key(recording->number) : std::nullopt;
                },
                true},
    PageMessage{kJobChannel,
                [](Bytes bytes) {
                  const auto job = decode_job(bytes);
                  return job ? Key(job->place) : std::nullopt;
                },
                true},
    PageMessage{kDocumentChannel,
                [](Bytes bytes) {
                  const auto part = decode_document_part(bytes);
                  return part ? Key(packed({part->place, part->part})) : std::nullopt;
                },
                false},
    PageMessage{kOrdersChannel, orders_key, false},
    PageMessage{kEnvelopeChannel, envelope_key, true},
    PageMessage{kWaterfallChannel, waterfall_key, true},
    PageMessage{kTransferFunctionChannel, transfer_function_key, true,
                [](Bytes bytes) { return decode_transfer_function(bytes)->viewer; }},
    PageMessage{kSpectrumChannel, spectrum_key, true,
                [](Bytes bytes) { return decode_spectrum(bytes)->viewer; }},
};

}  // namespace

std::span<const PageMessage> page_messages() {
  return kPageMessages;
}

}  // namespace roadbalance
