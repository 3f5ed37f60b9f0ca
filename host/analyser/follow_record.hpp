#pragma once

#include <chrono>
#include <stop_token>

#include "common/bus/control_messages.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/process/channel.hpp"
#include "host/analyser/analyser.hpp"
#include "host/analysis/balance/check_weights.hpp"

namespace roadbalance {

/// How often a growing record is looked at.
inline constexpr std::chrono::milliseconds kRecordPoll{50};

/// Process: the record as it grows -> identification, balance and orders on the bus.
///
/// Takes the blocks of each node in sequence and only those the recorder has acknowledged as durable, so that
/// the estimates are bit for bit those of the finished record.  A recorder that has been silent for some
/// seconds promises nothing more; then what the record holds counts.
///
/// Publishes each new estimate with its remarks, and the last one again every second for those who come late;
/// orders once a second.
///
/// @param before  gives the estimate of the drive before, if options name one: then it is compared with this
/// one
/// @param acks    brings the recorder's acknowledgements
void follow_record(std::stop_token stop, const AnalyserOptions& options, const VehicleConfig& vehicle,
                   In<BalancedDrive> before, In<Ack> acks);

}  // namespace roadbalance
