#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/bus_route.hpp"
#include "common/bus/message_format.hpp"

namespace roadbalance {

/// Names of LCM channels: one, or with ".*" behind it all that begin so.  LCM reads the same as a regular
/// expression; of these no other is taken.
class Channels {
 public:
  /// @throws std::invalid_argument naming what is neither
  explicit Channels(const std::string& pattern);

  bool operator==(const Channels&) const = default;
  bool has(std::string_view channel) const {
    return beginning_ ? channel.starts_with(text_) : channel == text_;
  }
  /// The first bytes of such a name in a datagram, where a zero ends it.
  std::string first_bytes() const { return beginning_ ? text_ : text_ + '\0'; }

 private:
  std::string text_;
  bool beginning_;
};

/// How runs of messages (MessageRun), and what a network card has put together, come.  Cut into datagrams
/// again they cost as much as if they had been sent one by one.
enum class Runs {
  kCut,   ///< as datagrams
  kWhole  ///< in one piece
};

struct Message {
  std::string_view channel;
  std::span<const std::uint8_t> bytes;
};

/// Messages that wait to be handled.
class Messages {
 public:
  bool empty() const { return taken_ == messages_.size(); }
  /// The oldest that has not been taken; valid until all are cleared.
  Message take() { return messages_[taken_++]; }
  void clear() {
    messages_.clear();
    taken_ = 0;
  }

 protected:
  ~Messages() = default;
  std::vector<Message> messages_;
  std::size_t taken_ = 0;
};

/// Datagrams that came together, and the messages in them.
class MessageBatch : public Messages {
 public:
  explicit MessageBatch(Runs runs);
  MessageBatch(const MessageBatch&) = delete;
  MessageBatch& operator=(const MessageBatch&) = delete;

  bool full() const { return datagrams_ == headers_.size(); }
  void clear() {
    Messages::clear();
    datagrams_ = 0;
  }

 private:
  friend class MessageSocket;
  struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(int))> of{};
  };

  std::unique_ptr<std::uint8_t[]> room_;  ///< its pages are touched by what comes only
  std::vector<iovec> places_;
  std::vector<Control> controls_;  ///< what the kernel reports of each
  std::vector<mmsghdr> headers_;
  std::size_t datagrams_ = 0;
};

/// The receiving end of LCM over UDP multicast, for messages of one packet, which all of ours are.
///
/// LCM's own takes three system calls and two wake-ups a datagram, more than all the rest of the link
/// (tools/bench), and that of 1.3.1 trusts what it receives: a fragment whose bounds wrap, or whose header is
/// cut short, ends the process (lcm#628).  Here datagrams that wait come by one system call, and nothing is
/// handed on but a whole message: the magic of a short one, a channel name that ends within the datagram, no
/// more than kLargestDatagram bytes.
class MessageSocket {
 public:
  static constexpr std::size_t kLargestDatagram = 1500;

  /// Joins the bus's group.
  /// @throws std::system_error
  MessageSocket(const BusAddress& bus, Runs runs);
  ~MessageSocket();
  MessageSocket(const MessageSocket&) = delete;
  MessageSocket& operator=(const MessageSocket&) = delete;

  /// Leaves messages on other channels in the kernel, where they cost a tenth: a node need not wake up for
  /// each block of all others.  Counts them as dropped().  A run is of one channel, so its first message
  /// decides whether it is wanted; but if runs come whole, what has come over a network is left to the
  /// reader, for what a card has put together is of any.  So is everything where the filter is too long for
  /// the kernel.
  /// @throws std::system_error
  void hear_only(std::span<const Channels> channels);

  /// As asked for, or kCut where the kernel gives no other: of what it takes into.
  Runs runs() const { return runs_; }
  /// True once something has come.  Once a second it joins the group again: the kernel ties a membership to
  /// an interface, and one that was taken out and put in again, as a network card at a USB port is, is
  /// another one.
  /// @throws std::system_error if the kernel takes no more: it counts interfaces that are gone, 20 in all
  bool wait(std::chrono::milliseconds timeout);
  /// Takes what has come, as much as there is room for behind what the batch holds.  False if nothing has.
  /// @throws std::system_error
  bool receive(MessageBatch& into);

  /// Bytes of its receive buffer, counted as one asks for them: of what the bus's address asks for the kernel
  /// gives no more than net.core.rmem_max.
  std::int64_t receive_buffer() const;

  /// Datagrams that were no message, and those that found the receive buffer full, a whole run as one.
  std::int64_t dropped() const;

 private:
  bool join();
  void stay_joined();
  void read(MessageBatch& into, std::size_t datagram);
  void read(MessageBatch& into, std::span<const std::uint8_t> message);

  const std::uint32_t group_;
  int socket_;
  std::chrono::steady_clock::time_point joined_{};
  Runs runs_;
  std::atomic<std::int64_t> refused_ = 0;  ///< asked for by another thread than that which receives
};

}  // namespace roadbalance
