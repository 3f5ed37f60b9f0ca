#pragma once

#include <atomic>
#include <string>

namespace roadbalance {

/// Reports the state of this program to the supervisor that started it (systemd, or rb supervise): one
/// datagram to $NOTIFY_SOCKET, as sd_notify(3).  Without a supervisor it does nothing.  Any thread may
/// report.
class ServiceNotify {
 public:
  /// @throws std::runtime_error naming the variable if $NOTIFY_SOCKET is no socket address
  ServiceNotify();
  ServiceNotify(const ServiceNotify&) = delete;
  ServiceNotify& operator=(const ServiceNotify&) = delete;
  ~ServiceNotify();

  bool has_supervisor() const { return socket_ >= 0; }

  void ready() { send("READY=1"); }
  /// To be sent when the end begins, which may be long before it is over.
  void stopping() { send("STOPPING=1"); }
  /// Proof of life, to be given only by a thread that has seen that all that matters still turns.
  void feed() { send("WATCHDOG=1"); }
  /// One line for people.
  void status(const std::string& line) { send("STATUS=" + line); }
  /// Datagrams the supervisor did not take.
  int unsent() const { return unsent_; }

 private:
  void send(const std::string& message);

  int socket_ = -1;
  std::atomic<int> unsent_ = 0;
};

}  // namespace roadbalance
