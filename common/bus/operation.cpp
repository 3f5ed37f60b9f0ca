#include "common/bus/operation.hpp"

#include <algorithm>
#include <cmath>
#include <wire/answer_t.hpp>
#include <wire/receipt_t.hpp>
#include <wire/request_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"
#include "common/frontend/front_end.hpp"
#include "common/link/block.hpp"

namespace roadbalance {
namespace {

using wire_text::put_text;
using wire_text::text_of;

constexpr std::int32_t kSumsNotKnown = 2;  // receipt_t.lcm

static_assert(sizeof(wire::request_t::text) == kMostRequestText);
static_assert(sizeof(wire::answer_t::text) == kMostRequestText);
static_assert(sizeof(wire::receipt_t::name) == kMostNameBytes);

bool is_number(std::int64_t number) {
  return 1 <= number && number < kRequestLimit;
}

bool is_count(std::int64_t count) {
  return 0 <= count && count <= kIndexLimit;
}

// Node 0 and channel -1: none in particular.
template <typename Message>
bool names_a_place(const Message& m) {
  return 0 <= m.node && m.node <= kLastNode && -1 <= m.channel && m.channel < kAccelerations &&
         std::isfinite(m.value[0]) && std::isfinite(m.value[1]);
}

bool in_bounds(const wire::receipt_t& m) {
  const bool is_empty = m.nodes == 0 && m.index == 0 && m.node == 0;
  const bool is_of_a_node = 1 <= m.node && m.node <= kLastNode && 0 <= m.index && m.index < m.nodes &&
                            m.nodes <= static_cast<std::int32_t>(kMostNodes);
  return (is_empty || is_of_a_node) && is_count(m.incarnation) && 0 <= m.open_epochs &&
         m.open_epochs <= m.epochs && is_count(m.samples_sent) && is_count(m.samples_recorded) &&
         is_count(m.gaps) && is_count(m.repaired) && std::isfinite(m.overload_s) && m.overload_s >= 0 &&
         std::isfinite(m.sync_us) && 0 <= m.end_sums && m.end_sums <= kSumsNotKnown && m.bytes >= 0 &&
         m.marks >= 0;
}

}  // namespace

std::vector<std::uint8_t> encode(const Request& r) {
  wire::request_t m{};
  m.asker = r.asker;
  m.request = r.request;
  m.operation = static_cast<std::int32_t>(r.operation);
  m.node = r.node;
  m.channel = r.channel;
  std::copy(r.value.begin(), r.value.end(), m.value);
  put_text(r.text, m.text, m.size);
  return wire_format::encode_with_crc(m);
}

std::optional<Request> decode_request(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::request_t>(bytes);
  if (!m || !is_number(m->asker) || !is_number(m->request) || !names_a_place(*m)) return std::nullopt;
  const auto text = text_of(m->text, m->size);
  if (!text) return std::nullopt;
  return Request{.asker = m->asker,
                 .request = m->request,
                 .operation = static_cast<Operation>(m->operation),
                 .node = m->node,
                 .channel = m->channel,
                 .value = {m->value[0], m->value[1]},
                 .text = *text};
}

std::vector<std::uint8_t> encode(const Answer& a) {
  wire::answer_t m{};
  m.asker = a.asker;
  m.request = a.request;
  m.time_us = a.time_us;
  m.operation = static_cast<std::int32_t>(a.operation);
  m.state = static_cast<std::int32_t>(a.state);
  m.reason = static_cast<std::int32_t>(a.reason);
  m.node = a.node;
  m.channel = a.channel;
  std::copy(a.value.begin(), a.value.end(), m.value);
  put_text(a.text, m.text, m.size);
  return wire_format::encode_with_crc(m);
}

std::optional<Answer> decode_answer(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::answer_t>(bytes);
  if (!m || !is_number(m->asker) || !is_number(m->request) || !names_a_place(*m) ||
      m->state < static_cast<std::int32_t>(AnswerState::kUnderWay) ||
      m->state > static_cast<std::int32_t>(AnswerState::kRefused) ||
      m->reason < static_cast<std::int32_t>(RefusalReason::kNone) ||
      m->reason > static_cast<std::int32_t>(RefusalReason::kBusy))
    return std::nullopt;
  const auto text = text_of(m->text, m->size);
  if (!text) return std::nullopt;
  return Answer{.asker = m->asker,
                .request = m->request,
                .time_us = m->time_us,
                .operation = static_cast<Operation>(m->operation),
                .state = static_cast<AnswerState>(m->state),
                .reason = static_cast<RefusalReason>(m->reason),
                .node = m->node,
                .channel = m->channel,
                .value = {m->value[0], m->value[1]},
                .text = *text};
}

std::vector<std::uint8_t> encode(const Receipt& r) {
  wire::receipt_t m{};
  m.incarnation = r.incarnation;
  m.began_us = r.began_us;
  m.ended_us = r.ended_us;
  m.index = r.index;
  m.nodes = r.nodes;
  m.node = r.node;
  m.epochs = r.epochs;
  m.open_epochs = r.open_epochs;
  m.samples_sent = r.samples_sent;
  m.samples_recorded = r.samples_recorded;
  m.gaps = r.gaps;
  m.repaired = r.repaired;
  m.overload_s = r.overload_s;
  m.sync_us = r.sync_us;
  m.blocks_crc32c = static_cast<std::int32_t>(r.blocks_crc32c);
  m.end_sums = !r.sums_agree ? kSumsNotKnown : *r.sums_agree ? 1 : 0;
  m.bytes = r.bytes;
  m.marks = r.marks;
  put_text(r.name, m.name, m.name_size);
  return wire_format::encode_with_crc(m);
}

std::optional<Receipt> decode_receipt(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::receipt_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  const auto name = text_of(m->name, m->name_size);
  if (!name) return std::nullopt;
  return Receipt{.incarnation = m->incarnation,
                 .began_us = m->began_us,
                 .ended_us = m->ended_us,
                 .index = m->index,
                 .nodes = m->nodes,
                 .node = m->node,
                 .epochs = m->epochs,
                 .open_epochs = m->open_epochs,
                 .samples_sent = m->samples_sent,
                 .samples_recorded = m->samples_recorded,
                 .gaps = m->gaps,
                 .repaired = m->repaired,
                 .overload_s = m->overload_s,
                 .sync_us = m->sync_us,
                 .blocks_crc32c = static_cast<std::uint32_t>(m->blocks_crc32c),
                 .sums_agree = m->end_sums == kSumsNotKnown ? std::nullopt : std::optional(m->end_sums != 0),
                 .bytes = m->bytes,
                 .marks = m->marks,
                 .name = *name};
}

}  // namespace roadbalance
