#include "common/bus/operation.hpp"

#include <wire/answer_t.hpp>
#include <wire/receipt_t.hpp>
#include <wire/request_t.hpp>

#include "common/bus/fields.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {
namespace wire_fields {

/// The fields by which an answer and its request belong together.
template <typename Field, typename Message, typename Wire>
void list_numbers(Field& field, Message& message, Wire& m) {
  field(message.asker, m.asker, within(1, kRequestLimit - 1));
  field(message.request, m.request, within(1, kRequestLimit - 1));
}

/// Where; node 0 and channel -1: none in particular.
template <typename Field, typename Message, typename Wire>
void list_place(Field& field, Message& message, Wire& m) {
  field(message.node, m.node, up_to(kLastNode));
  field(message.channel, m.channel, within(-1, kAccelerations - 1));
  field(message.value, m.value, is_finite);
}

template <>
struct Fields<Request> {
  using Wire = wire::request_t;
  static void list(auto& field, auto& r, auto& m) {
    list_numbers(field, r, m);
    field(r.operation, m.operation);
    list_place(field, r, m);
    field.text(r.text, m.text, m.size);
    field.text(r.nodes, m.nodes, m.nodes_size);
    field.text(r.who, m.who, m.who_size);
  }
};

template <>
struct Fields<Answer> {
  using Wire = wire::answer_t;
  static void list(auto& field, auto& a, auto& m) {
    list_numbers(field, a, m);
    field(a.time_us, m.time_us);
    field(a.operation, m.operation);
    field(a.state, m.state, within(AnswerState::kUnderWay, AnswerState::kRefused));
    field(a.reason, m.reason, up_to(RefusalReason::kBusy));
    list_place(field, a, m);
    field.text(a.text, m.text, m.size);
  }
};

template <>
struct Fields<Receipt> {
  using Wire = wire::receipt_t;
  static void list(auto& field, auto& r, auto& m) {
    field(r.incarnation, m.incarnation, is_index);
    field(r.began_us, m.began_us);
    field(r.ended_us, m.ended_us);
    field(r.index, m.index);
    field(r.nodes, m.nodes, up_to(kMostNodes));
    field(r.node, m.node);
    const bool is_empty = m.nodes == 0 && m.index == 0 && m.node == 0;
    field.require(is_empty || (is_node(m.node) && below(m.nodes)(m.index)));
    field(r.epochs, m.epochs);
    field(r.open_epochs, m.open_epochs, up_to(m.epochs));
    field(r.samples_sent, m.samples_sent, is_index);
    field(r.samples_recorded, m.samples_recorded, is_index);
    field(r.gaps, m.gaps, is_index);
    field(r.repaired, m.repaired, is_index);
    field(r.overload_s, m.overload_s, is_size);
    field(r.sync_us, m.sync_us, is_finite);
    field(r.blocks_crc32c, m.blocks_crc32c);
    field.flag_if_known(r.sums_agree, m.end_sums);
    field(r.bytes, m.bytes, at_least(0));
    field(r.marks, m.marks, at_least(0));
    field.text(r.name, m.name, m.name_size);
    field.text(r.absence, m.absence, m.absence_size);
    field.text(r.unheard, m.unheard, m.unheard_size);
    field.text(r.stopped_by, m.stopped_by, m.stopped_by_size);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::request_t::text) == kMostRequestText);
static_assert(sizeof(wire::answer_t::text) == kMostRequestText);
static_assert(sizeof(wire::receipt_t::name) == kMostNameBytes);
static_assert(sizeof(wire::receipt_t::absence) == kMostAbsenceBytes);
static_assert(sizeof(wire::receipt_t::unheard) == kMostWhoBytes);
static_assert(sizeof(wire::receipt_t::stopped_by) == kMostWhoBytes);
static_assert(sizeof(wire::request_t::who) == kMostWhoBytes);
static_assert(sizeof(wire::request_t::nodes) == kMostNodesText);

Answer answer_to(const Request& request, std::int64_t utc_us) {
  return {.asker = request.asker,
          .request = request.request,
          .time_us = utc_us,
          .operation = request.operation,
          .node = request.node,
          .channel = request.channel,
          .value = request.value};
}

std::vector<std::uint8_t> encode(const Request& request) {
  return wire_fields::encode(request);
}
std::vector<std::uint8_t> encode(const Answer& answer) {
  return wire_fields::encode(answer);
}
std::vector<std::uint8_t> encode(const Receipt& receipt) {
  return wire_fields::encode(receipt);
}
std::optional<Request> decode_request(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Request>(bytes);
}
std::optional<Answer> decode_answer(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Answer>(bytes);
}
std::optional<Receipt> decode_receipt(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Receipt>(bytes);
}

}  // namespace roadbalance
