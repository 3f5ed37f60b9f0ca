#include "common/bus/compensation.hpp"
#include "common/bus/display.hpp"
#include "common/bus/job.hpp"
#include "common/bus/knock.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/recording.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/setup.hpp"
#include "common/bus/transfer_report.hpp"
#include "common/bus/verification.hpp"
#include "hil_tests/fuzz/round_trip.hpp"

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
  fuzz::check_message<TransferPart>(bytes, decode_transfer);
  fuzz::check_message<Envelope>(bytes, decode_envelope);
  fuzz::check_message<WaterfallRow>(bytes, decode_waterfall);
  fuzz::check_message<Remark>(bytes, decode_remark);
  fuzz::check_message<Knock>(bytes, decode_knock);
  fuzz::check_message<NodeSetup>(bytes, decode_setup);
  fuzz::check_message<WheelVerification>(bytes, decode_verification);
  fuzz::check_message<RecordingReceipt>(bytes, decode_recording);
  fuzz::check_message<Job>(bytes, decode_job);
  fuzz::check_message<DocumentPart>(bytes, decode_document_part);
  return 0;
}
