#include "firmware/backends/usb/usb_front_end.hpp"

#include <chrono>
#include <utility>
#include <vector>

#include "firmware/backends/usb/board_link.hpp"
#include "firmware/backends/usb/board_reader.hpp"

namespace roadbalance {
namespace {

constexpr auto kLongestWait = std::chrono::milliseconds(100);

/// Reads the front-end board, or two.
class UsbFrontEnd final : public FrontEnd {
 public:
  UsbFrontEnd(const UsbAddress& address, const FrontEndRequest& request,
              std::function<void(const std::string&)> warn)
      : reports_(make_reports(address)),
        link_(address, request.vehicle, request.node, pointers(), std::move(warn)),
        reader_(pointers(), request.node.rate_hz, request.node.channel.size(), link_.lines()) {}

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample>) noexcept override {
    Read read;
    const WallTime until = WallClock::now() + kLongestWait;
    Inbox& inbox = link_.inbox();
    while (reader_.hand_over(scans, edges, read)) {
      if (!inbox.front() && (read.scans > 0 || !inbox.wait_until(until))) break;
      reader_.take(*inbox.front());
      inbox.pop();
    }
    if (!reader_.aligned()) link_.start_again(reader_.token());
    for (std::size_t k = 0; k < reports_.size(); ++k) link_.hear(k, reader_.token(), reader_.flow(k));
    return read;
  }

  std::vector<const DeviceReport*> reports() const override {
    std::vector<const DeviceReport*> all;
    for (const auto& report : reports_) all.push_back(report.get());
    return all;
  }

 private:
  using Reports = std::vector<std::unique_ptr<DeviceReport>>;

  static Reports make_reports(const UsbAddress& address) {
    Reports reports;
    for (std::size_t k = 0; k < address.boards(); ++k)
      reports.push_back(std::make_unique<DeviceReport>(address.of_board(k)));
    return reports;
  }
  std::vector<DeviceReport*> pointers() const {
    std::vector<DeviceReport*> all;
    for (const auto& report : reports_) all.push_back(report.get());
    return all;
  }

  const Reports reports_;
  BoardLink link_;
  BoardReader reader_;
};

}  // namespace

std::unique_ptr<FrontEnd> open_usb_front_end(const FrontEndRequest& request,
                                             std::function<void(const std::string&)> warn) {
  return std::make_unique<UsbFrontEnd>(UsbAddress::parse(request.address), request, std::move(warn));
}

}  // namespace roadbalance
