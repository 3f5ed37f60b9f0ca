#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"
#include "common/types/block.hpp"

/// Each field of a message is written once: beside its field on the wire, with its bounds.  The list of a
/// message serves encoding, the check of bytes from outside, and decoding.  For use inside common/bus only.
///
///     template <>
///     struct Fields<Ack> {
///       using Wire = wire::ack_t;
///       static void list(auto& field, auto& a, auto& m) {
///         field(a.node, m.node, is_node);
///         field(a.epoch, m.epoch);
///         ...
///
/// `a` is the message and `m` its generated type.  A list runs forward over both: a bound may name fields of
/// `m` that stand before it.
namespace roadbalance::wire_fields {

// Bounds of a number on the wire, both ends included; NaN is outside all but of is_not_infinite().

template <typename Number>
struct Within {
  Number low, high;
  constexpr bool operator()(Number value) const { return low <= value && value <= high; }
};

/// Bounds of numbers or enumerators.
template <typename Low, typename High>
constexpr auto within(Low low, High high) {
  if constexpr (std::is_floating_point_v<Low>)
    return Within<double>{low, high};
  else
    return Within<std::int64_t>{static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)};
}

template <typename High>
constexpr auto up_to(High high) {
  return within(0, high);
}

/// Bounds of an index into so many.
template <typename Count>
constexpr auto below(Count count) {
  return within(0, static_cast<std::int64_t>(count) - 1);
}

template <typename Low>
constexpr auto at_least(Low low) {
  if constexpr (std::is_floating_point_v<Low>)
    return within(low, std::numeric_limits<double>::infinity());
  else
    return within(low, std::numeric_limits<std::int64_t>::max());
}

inline bool is_clock(std::int64_t ns) {
  return -kClockLimit_ns <= ns && ns <= kClockLimit_ns;
}
inline bool is_finite(double value) {
  return std::isfinite(value);
}
inline bool is_size(double value) {
  return std::isfinite(value) && value >= 0.0;
}
inline bool is_not_infinite(double value) {
  return !std::isinf(value);
}

struct Anything {
  constexpr bool operator()(auto) const { return true; }
};

template <typename Message>
struct Fields;

enum class Pass {
  kEncode,  ///< message to wire, which must be zeros before
  kCheck,   ///< bounds of the wire; the message is not touched
  kDecode,  ///< wire, which must have passed the check, to message
};

/// One run over a list.
template <Pass kPass>
class FieldPass {
 public:
  /// False once the check has met something out of bounds: from there on nothing is looked at.
  bool is_good() const { return good_; }

  /// A number, an enumerator, a bool, a complex number, a matrix of Eigen, or an array of these, whose
  /// extents on the wire may be larger.  The bound holds for each element of the wire.
  template <typename Value, typename Wire, typename Bound = Anything>
  void operator()(Value& value, Wire& wire, Bound bound = {}) {
    if constexpr (kPass == Pass::kCheck)
      check(wire, bound);
    else if constexpr (!std::is_array_v<Wire>)
      move(value, wire);
    else if constexpr (requires { value(0, 0); })
      move_matrix(value, wire);
    else if constexpr (requires { value.real(); })
      move_complex(value, wire);
    else
      move_array(value, wire);
  }

  /// An array that travels whole, of which `count` elements, which stood before it in the list, count: only
  /// these are bounded.
  template <typename Value, typename Wire, std::size_t kExtent, typename Count, typename Bound>
  void counted(Value& value, Wire (&wire)[kExtent], const Count& count, Bound bound) {
    if constexpr (kPass == Pass::kCheck)
      for (Count k = 0; k < count && good_; ++k) check(wire[k], bound);
    else
      move_array(value, wire);
  }

  /// A field that another one writes: here it is only read.
  template <typename Value, typename Wire>
  void read_only(Value& value, Wire& wire) {
    if constexpr (kPass == Pass::kDecode) move(value, wire);
  }

  /// A bool in one bit of a number.
  template <typename Value, typename Wire>
  void bit(Value& value, Wire& wire, int bit) {
    if constexpr (kPass == Pass::kEncode) wire |= (value ? 1 : 0) << bit;
    if constexpr (kPass == Pass::kDecode) value = (wire >> bit & 1) != 0;
  }

  /// A std::optional<bool>: 0, 1, and 2 for one that is not known.
  template <typename Value, typename Wire>
  void flag_if_known(Value& value, Wire& wire) {
    constexpr std::int32_t kNotKnown = 2;
    if constexpr (kPass == Pass::kEncode) wire = !value ? kNotKnown : *value ? 1 : 0;
    check(wire, up_to(kNotKnown));
    if constexpr (kPass == Pass::kDecode) {
      value.reset();
      if (wire != kNotKnown) value = wire != 0;
    }
  }

  /// Text for people: sent plain and cut to what fits, refused unless plain.
  template <typename Text, typename Byte, std::size_t kBytes, typename Size>
  void text(Text& text, Byte (&bytes)[kBytes], Size& size) {
    if constexpr (kPass == Pass::kEncode) wire_text::put_text(text, bytes, size);
    check(size, up_to(kBytes));
    if constexpr (kPass == Pass::kCheck)
      require_if_good([&] { return wire_text::is_plain_text(view(bytes, size)); });
    if constexpr (kPass == Pass::kDecode) text.assign(bytes, bytes + size);
  }

  /// The same without a size: it ends where zeros begin, and is made plain as it is read.
  template <typename Text, typename Byte, std::size_t kBytes>
  void text(Text& text, Byte (&bytes)[kBytes]) {
    if constexpr (kPass == Pass::kEncode) wire_text::put_text(text, bytes);
    if constexpr (kPass == Pass::kDecode) text = wire_text::text_until_zero(bytes);
  }

  /// The same with a size, made plain as it is read: no text is refused.
  template <typename Text, typename Byte, std::size_t kBytes, typename Size>
  void text_made_plain(Text& text, Byte (&bytes)[kBytes], Size& size) {
    if constexpr (kPass == Pass::kEncode) wire_text::put_text(text, bytes, size);
    check(size, up_to(kBytes));
    if constexpr (kPass == Pass::kDecode) text = wire_text::plain_text(view(bytes, size));
  }

  /// Bytes as they are, at least `least`; more than fit are cut.
  template <typename Text, typename Byte, std::size_t kBytes, typename Size>
  void bytes(Text& text, Byte (&bytes)[kBytes], Size& size, std::size_t least = 0) {
    if constexpr (kPass == Pass::kEncode) {
      size = static_cast<Size>(std::min(text.size(), kBytes));
      std::copy_n(text.begin(), size, bytes);
    }
    check(size, within(least, kBytes));
    if constexpr (kPass == Pass::kDecode) text.assign(bytes, bytes + size);
  }

  /// A vector whose elements' fields lie in arrays of the wire, of which `count` elements count, at most
  /// `most`.
  /// @param row  its fields: row(element, k)
  template <typename Rows, typename Count, typename Row>
  void rows(Rows& rows, Count& count, std::size_t most, Row row) {
    if constexpr (kPass == Pass::kEncode) assert(rows.size() <= most);
    first_rows(rows, count, most, row);
  }

  /// The same of a vector that may have more, which are not sent.
  template <typename Rows, typename Count, typename Row>
  void first_rows(Rows& rows, Count& count, std::size_t most, Row row) {
    if constexpr (kPass == Pass::kEncode) count = static_cast<Count>(std::min(rows.size(), most));
    check(count, up_to(most));
    if (!good_) return;
    const auto size = static_cast<std::size_t>(count);
    if constexpr (kPass == Pass::kCheck) {
      typename std::remove_const_t<Rows>::value_type none{};
      for (std::size_t k = 0; k < size && good_; ++k) row(none, k);
    } else {
      if constexpr (kPass == Pass::kDecode) rows.resize(size);
      for (std::size_t k = 0; k < size; ++k) row(rows[k], k);
    }
  }

  /// A vector of numbers in one array.
  template <typename Values, typename Count, typename Wire, std::size_t kMost>
  void values(Values& values, Count& count, Wire (&wire)[kMost]) {
    rows(values, count, kMost, [&](auto& value, std::size_t k) { (*this)(value, wire[k]); });
  }

  /// A condition on several fields together.
  void require(bool condition) {
    if constexpr (kPass == Pass::kCheck) good_ = good_ && condition;
  }

 private:
  template <typename Wire, typename Bound>
  void check(const Wire& wire, const Bound& bound) {
    if constexpr (kPass != Pass::kCheck)
      return;
    else if constexpr (std::is_array_v<Wire>)
      for (const auto& each : wire) check(each, bound);
    else
      require_if_good([&] { return bound(wire); });
  }

  template <typename Condition>
  void require_if_good(Condition condition) {
    if constexpr (kPass == Pass::kCheck) good_ = good_ && condition();
  }

  template <typename Value, typename Wire>
  static void move(Value& value, Wire& wire) {
    static_assert(
        std::is_same_v<Value, bool> || std::is_same_v<Value, const bool> ||
        (sizeof(Value) <= sizeof(Wire) && std::is_floating_point_v<Value> == std::is_floating_point_v<Wire>));
    if constexpr (kPass == Pass::kEncode) wire = static_cast<Wire>(value);
    if constexpr (kPass == Pass::kDecode) value = static_cast<Value>(wire);
  }

  template <typename Value, typename Wire>
  static void move_complex(Value& value, Wire& wire) {
    auto real = value.real(), imaginary = value.imag();
    move(real, wire[0]);
    move(imaginary, wire[1]);
    if constexpr (kPass == Pass::kDecode) value = {real, imaginary};
  }

  template <typename Value, typename Wire, std::size_t kRows>
  static void move_matrix(Value& value, Wire (&wire)[kRows]) {
    for (std::size_t row = 0; row < kRows; ++row)
      if constexpr (std::is_array_v<Wire>)
        for (std::size_t column = 0; column < std::extent_v<Wire>; ++column)
          move(value(static_cast<int>(row), static_cast<int>(column)), wire[row][column]);
      else
        move(value(static_cast<int>(row), 0), wire[row]);
  }

  template <typename Value, typename Wire, std::size_t kExtent>
  void move_array(Value& value, Wire (&wire)[kExtent]) {
    static_assert(std::tuple_size_v<std::remove_const_t<Value>> <= kExtent);
    for (std::size_t k = 0; k < value.size(); ++k) (*this)(value[k], wire[k]);
  }

  template <typename Byte, std::size_t kBytes>
  static std::string_view view(const Byte (&bytes)[kBytes], std::int32_t size) {
    return {reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size)};
  }

  bool good_ = true;
};

/// Generated types have a last field crc32c or none.
template <typename Wire>
inline constexpr bool kHasCrc = requires(Wire m) {
  m.crc32c;
};

template <typename Message>
typename Fields<Message>::Wire wire_of(const Message& message) {
  typename Fields<Message>::Wire wire{};
  FieldPass<Pass::kEncode> encode;
  Fields<Message>::list(encode, message, wire);
  return wire;
}

template <typename Message>
bool in_bounds(const typename Fields<Message>::Wire& wire) {
  Message none{};
  FieldPass<Pass::kCheck> check;
  Fields<Message>::list(check, none, wire);
  return check.is_good();
}

/// Decodes a wire that is in bounds.
template <typename Message>
Message message_of(const typename Fields<Message>::Wire& wire) {
  Message message{};
  FieldPass<Pass::kDecode> decode;
  Fields<Message>::list(decode, message, wire);
  return message;
}

template <typename Message>
std::vector<std::uint8_t> encode(const Message& message) {
  if constexpr (kHasCrc<typename Fields<Message>::Wire>)
    return wire_format::encode_with_crc(wire_of(message));
  else
    return wire_format::encode(wire_of(message));
}

/// Refuses wrong size, type, CRC, and what is out of bounds.
template <typename Message>
std::optional<Message> decode(std::span<const std::uint8_t> bytes) {
  using Wire = typename Fields<Message>::Wire;
  std::optional<Wire> wire;
  if constexpr (kHasCrc<Wire>)
    wire = wire_format::decode_with_crc<Wire>(bytes);
  else
    wire = wire_format::decode<Wire>(bytes);
  if (!wire || !in_bounds<Message>(*wire)) return std::nullopt;
  return message_of<Message>(*wire);
}

}  // namespace roadbalance::wire_fields
