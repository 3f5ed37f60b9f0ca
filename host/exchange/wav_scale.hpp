#pragma once

namespace roadbalance {

/// A sample of a WAV file is its counts times this: counts of 24 bits, and a reference of 1.0, which is a
/// count more, stay whole within 32 bits.
inline constexpr int kWavSamplesPerCount = 128;

}  // namespace roadbalance
